// Seconds that the processors have worked for this process so far: all its threads, and the system on their behalf.
#pragma once

#include <ctime>

namespace ldp {

inline double processor_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace ldp
