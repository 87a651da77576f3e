#define LDP_KERNELS base
#include "kernels.inc"

namespace ldp::render::kernels {

#if defined(__x86_64__)
namespace avx2 {
extern const Kernels kKernels;
}
#endif

const Kernels& best() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return avx2::kKernels;
#endif
  return base::kKernels;
}

const Kernels& plain() { return base::kKernels; }

}  // namespace ldp::render::kernels
