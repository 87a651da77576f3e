// Compiled with -mavx2; must include nothing whose functions could be shared with files that are not.
#if defined(__x86_64__)
#define LDP_KERNELS avx2_kernels
#include "core/solve/moves/message_passing.inc"
#endif
