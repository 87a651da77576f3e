// Waiting for descriptors: the one place where the service sleeps.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace ldp {

struct Watch {
  int fd = -1;
  std::function<void()> serve;  // called when it is readable
};
using Watches = std::vector<Watch>;

// Sleeps until one of `watches()` is readable or CLOCK_MONOTONIC has come to the deadline, and serves those that are.
// Serving one may close another, or open one in its place: the rest waits for the next call then. Throws
// std::system_error.
void wait_and_serve(const std::function<Watches()>& watches, int64_t deadline_ns);

}  // namespace ldp
