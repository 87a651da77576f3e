// Compiled with -mavx2; must include nothing whose functions could be shared with files that are not.
#if defined(__x86_64__)
#define LDP_KERNELS avx2
#include "core/layers/painting/view_kernels.inc"
#endif
