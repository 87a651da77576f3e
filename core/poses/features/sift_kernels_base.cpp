#define LDP_SIFT base
#include "core/poses/features/sift_kernels.inc"

#define LDP_DISPATCHED ldp::sfm::sift
#include "core/base/kernel_dispatch.inc"
