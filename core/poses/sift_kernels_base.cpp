#define LDP_SIFT base
#include "sift_kernels.inc"

#define LDP_DISPATCHED ldp::sift
#include "kernel_dispatch.inc"
