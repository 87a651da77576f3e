#define LDP_KERNELS base
#include "kernels.inc"

#define LDP_DISPATCHED ldp::render::kernels
#include "kernel_dispatch.inc"
