#include "device/service/events/end_request.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <utility>

#include "drivers/interface/errors.h"

namespace ldp {
namespace {

UniqueFd event_descriptor() {
  UniqueFd fd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!fd.is_open()) throw_errno("cannot make an event descriptor");
  return fd;
}

UniqueFd ending_signals() {
  sigset_t wanted;
  sigemptyset(&wanted);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&wanted, signal);
  ::pthread_sigmask(SIG_BLOCK, &wanted, nullptr);
  UniqueFd fd(::signalfd(-1, &wanted, SFD_NONBLOCK | SFD_CLOEXEC));
  if (!fd.is_open()) throw_errno("cannot receive signals");
  return fd;
}

}  // namespace

EndRequest::EndRequest(std::stop_token stop) : fd_(stop.stop_possible() ? event_descriptor() : ending_signals()) {
  if (!stop.stop_possible()) return;
  on_stop_.emplace(std::move(stop), [fd = fd_.get()] {
    const uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = ::write(fd, &one, sizeof one);
  });
}

bool EndRequest::take() {
  char request[sizeof(signalfd_siginfo)];
  return ::read(fd_.get(), request, sizeof request) > 0;
}

bool EndRequest::waits() const {
  pollfd entry{fd_.get(), POLLIN, 0};
  return ::poll(&entry, 1, 0) > 0;
}

}  // namespace ldp
