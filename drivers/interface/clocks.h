// The two clocks of the device, in nanoseconds. Intervals and frame times are monotonic; UTC is only ever shown.
#pragma once

#include <cstdint>

namespace ldp {

int64_t monotonic_now_ns();
int64_t utc_now_ns();

// Whether something that knows the time (a network's servers, a receiver) has set the clock of UTC and keeps it: as the
// kernel says (adjtimex), or systemd-timesyncd where a sandbox does not let the kernel be asked.
bool utc_is_synchronized();

// "2026-01-31T12:00:00Z"
const char* utc_text(int64_t utc_ns, char (&buffer)[32]);

}  // namespace ldp
