#define LDP_KERNELS base
#include "core/view/raster/raster_kernels.inc"

#define LDP_DISPATCHED ldp::view::kernels
#include "core/base/kernel_dispatch.inc"
