// Whether tests, and the programs that they start, are built with AddressSanitizer or ThreadSanitizer, and how a test
// that cannot hold there says so. Such tests: grep -r NOT_UNDER tests; for those that are no GoogleTest,
// ldp_not_under_sanitizers in tests/CMakeLists.txt. Single checks of the tests in Python: LDP_SANITIZED.
#pragma once

#include <gtest/gtest.h>

#if !defined(__has_feature)
#define __has_feature(name) 0
#endif

namespace ldp {

#if defined(__SANITIZE_THREAD__) || __has_feature(thread_sanitizer)
inline constexpr bool kThreadSanitized = true;
#else
inline constexpr bool kThreadSanitized = false;
#endif

#if defined(__SANITIZE_ADDRESS__) || __has_feature(address_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = kThreadSanitized;
#endif

}  // namespace ldp

// End the test as skipped where it is sanitized. `reason`: of principle, never that something was found.
#define NOT_UNDER_SANITIZERS(reason) \
  if (ldp::kSanitized) GTEST_SKIP() << "not under sanitizers: " << (reason)
#define NOT_UNDER_THREAD_SANITIZER(reason) \
  if (ldp::kThreadSanitized) GTEST_SKIP() << "not under ThreadSanitizer: " << (reason)
