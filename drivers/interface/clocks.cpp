#include "drivers/interface/clocks.h"

#include <sys/timex.h>
#include <unistd.h>

#include <ctime>

namespace ldp {
namespace {

int64_t now_ns(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

int64_t monotonic_now_ns() { return now_ns(CLOCK_MONOTONIC); }
int64_t utc_now_ns() { return now_ns(CLOCK_REALTIME); }

bool utc_is_synchronized() {
  timex question{};
  const int state = ::adjtimex(&question);
  return (state >= 0 && state != TIME_ERROR) || ::access("/run/systemd/timesync/synchronized", F_OK) == 0;
}

const char* utc_text(int64_t utc_ns, char (&buffer)[32]) {
  const time_t seconds = static_cast<time_t>(utc_ns / 1'000'000'000);
  tm parts{};
  gmtime_r(&seconds, &parts);
  if (strftime(buffer, sizeof buffer, "%Y-%m-%dT%H:%M:%SZ", &parts) == 0) buffer[0] = '\0';
  return buffer;
}

}  // namespace ldp
