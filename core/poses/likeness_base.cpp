#define LDP_LIKENESS base
#include "likeness.inc"

#define LDP_DISPATCHED ldp::likeness
#include "kernel_dispatch.inc"
