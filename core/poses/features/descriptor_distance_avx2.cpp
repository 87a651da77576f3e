// Compiled with -mavx2; must include nothing whose functions could be shared with files that are not.
#if defined(__x86_64__)
#define LDP_LIKENESS avx2
#include "core/poses/features/descriptor_distance.inc"
#endif
