#define LDP_LIKENESS base
#include "core/poses/features/descriptor_distance.inc"

#define LDP_DISPATCHED ldp::likeness
#include "core/base/kernel_dispatch.inc"
