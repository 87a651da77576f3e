#define LDP_KERNELS base
#include "core/sweep/sweep_kernels.inc"

#define LDP_DISPATCHED ldp::sweep::kernels
#include "core/base/kernel_dispatch.inc"
