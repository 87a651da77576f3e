#define LDP_DESCRIPTOR_DISTANCE base
#include "core/poses/features/descriptor_distance.inc"

#define LDP_DISPATCHED ldp::sfm::descriptor_distance
#include "core/base/kernel_dispatch.inc"
