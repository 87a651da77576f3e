// Whether tests, and the programs that they start, are built with AddressSanitizer or ThreadSanitizer, and how a test
// that cannot hold there says so. Such tests: grep -r NOT_UNDER_SANITIZERS tests; for those that are no GoogleTest,
// ldp_not_under_sanitizers in tests/CMakeLists.txt. Single checks of the tests in Python: LDP_SANITIZED.
#pragma once

#include <gtest/gtest.h>

namespace ldp {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace ldp

// Ends the test as skipped where it is sanitized. `reason`: of principle, never that something was found.
#define NOT_UNDER_SANITIZERS(reason) \
  if (ldp::kSanitized) GTEST_SKIP() << "not under sanitizers: " << (reason)
