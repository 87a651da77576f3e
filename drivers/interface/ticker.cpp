#include "drivers/interface/ticker.h"

#include <sys/timerfd.h>
#include <unistd.h>

#include "drivers/interface/errors.h"

namespace ldp {
namespace {

timespec timespec_from(int64_t ns) {
  timespec time{};
  time.tv_sec = static_cast<time_t>(ns / 1'000'000'000);
  time.tv_nsec = static_cast<decltype(time.tv_nsec)>(ns % 1'000'000'000);
  return time;
}

}  // namespace

Ticker::Ticker() : fd_(timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)) {
  if (!fd_.is_open()) throw_errno("cannot make a timer");
}

void Ticker::start_at(int64_t first_ns, int64_t interval_ns) {
  itimerspec spec{};
  spec.it_value = timespec_from(first_ns > 0 ? first_ns : 1);
  spec.it_interval = timespec_from(interval_ns);
  if (timerfd_settime(fd_.get(), TFD_TIMER_ABSTIME, &spec, nullptr) != 0) throw_errno("cannot set a timer");
}

void Ticker::stop() {
  const itimerspec never{};
  timerfd_settime(fd_.get(), 0, &never, nullptr);
  take_expirations();
}

uint64_t Ticker::take_expirations() {
  uint64_t count = 0;
  return ::read(fd_.get(), &count, sizeof count) == sizeof count ? count : 0;
}

}  // namespace ldp
