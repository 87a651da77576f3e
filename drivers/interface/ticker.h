// A timer as a file descriptor: fires at a moment of the monotonic clock, once or again and again.
#pragma once

#include <cstdint>

#include "drivers/interface/unique_fd.h"

namespace ldp {

class Ticker {
 public:
  Ticker();
  int fd() const { return fd_.get(); }
  void start_at(int64_t first_ns, int64_t interval_ns);  // interval 0: once
  void stop();
  uint64_t take_expirations();  // since the last call; never blocks

 private:
  UniqueFd fd_;
};

}  // namespace ldp
