#define LDP_KERNELS base
#include "core/view/raster/raster_kernels.inc"

#define LDP_DISPATCHED ldp::render::kernels
#include "core/base/kernel_dispatch.inc"
