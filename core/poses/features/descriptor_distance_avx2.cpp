// Compiled with -mavx2; must include nothing whose functions could be shared with files that are not.
#if defined(__x86_64__)
#define LDP_DESCRIPTOR_DISTANCE avx2
#include "core/poses/features/descriptor_distance.inc"
#endif
