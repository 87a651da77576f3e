#define LDP_KERNELS base
#include "core/layers/painting/view_kernels.inc"

#define LDP_DISPATCHED ldp::layers::kernels
#include "core/base/kernel_dispatch.inc"
