#define LDP_KERNELS base
#include "core/sweep/sweep_kernels.inc"

#define LDP_DISPATCHED ldp::kernels
#include "core/base/kernel_dispatch.inc"
