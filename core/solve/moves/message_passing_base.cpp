#define LDP_KERNELS base_kernels
#include "core/solve/moves/message_passing.inc"

namespace ldp::solve {

const MessageKernels& message_kernels() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return avx2_kernels::kMessageKernels;
#endif
  return base_kernels::kMessageKernels;
}

}  // namespace ldp::solve
