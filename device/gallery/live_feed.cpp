#include "device/gallery/live_feed.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <cerrno>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/captures/json_text.h"
#include "device/capture/log.h"
#include "device/gallery/status_json.h"
#include "drivers/interface/clocks.h"

namespace ldp::gallery {
namespace {

constexpr size_t kMostFollowers = 400;
constexpr int kSilence_ms = 10'000;  // at most: a follower that is gone is noticed by writing
constexpr int kRetry_ms = 2'000;     // from one try to reach the device to the next

std::string event_of(const StatusMessage& message) { return "data: " + json_text(json_from(message)) + "\n\n"; }

// All of it at once, or the follower has not read for long.
bool tell(int follower, const std::string& text) {
  const ssize_t sent = ::send(follower, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  return sent == static_cast<ssize_t>(text.size());
}

}  // namespace

LiveFeed::LiveFeed(Open open) : open_(std::move(open)), wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!wake_.is_open()) throw std::system_error(errno, std::generic_category(), "cannot make an eventfd");
  thread_ = std::thread([this] { run(); });
}

LiveFeed::~LiveFeed() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake();
  thread_.join();
}

void LiveFeed::wake() const {
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t put = ::write(wake_.get(), &one, sizeof one);
}

void LiveFeed::add(UniqueFd follower) {
  const std::lock_guard lock(mutex_);
  if (followers_.size() >= kMostFollowers) return;
  std::string known = ": connected\n\n";
  for (const std::string& event : last_) known += event;
  if (tell(follower.get(), known)) followers_.push_back(std::move(follower));
}

void LiveFeed::send(Command command) {
  const std::lock_guard lock(mutex_);
  if (!listener_) throw std::runtime_error("the device cannot be reached just now: try again in a moment");
  listener_->send(command);
}

void LiveFeed::tell_all(const std::string& event) {
  std::erase_if(followers_, [&](const UniqueFd& follower) { return !tell(follower.get(), event); });
}

void LiveFeed::hear() {
  const std::lock_guard lock(mutex_);
  while (const std::optional<HeardMessage> heard = listener_->read()) {
    std::string& last = last_[heard->message.index()];
    last = event_of(heard->message);
    tell_all(last);
  }
}

void LiveFeed::open_missing() {
  const int64_t now_ns = monotonic_now_ns();
  if (!open_ || (listener_ && !listener_->ended()) || now_ns < next_try_ns_) return;
  next_try_ns_ = now_ns + int64_t{kRetry_ms} * 1'000'000;
  std::string problem;
  std::unique_ptr<StatusListener> fresh;
  try {
    fresh = open_();
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (!problem.empty() && problem != problem_) log_warning(problem + "; trying again until the device is there");
  problem_ = problem;
  const std::lock_guard lock(mutex_);
  listener_ = std::move(fresh);
}

void LiveFeed::run() {
  for (;;) {
    open_missing();
    const bool listens = listener_ && !listener_->ended();
    pollfd entries[] = {{wake_.get(), POLLIN, 0}, {listens ? listener_->fd() : -1, POLLIN, 0}};
    const int ready = ::poll(entries, 2, open_ && !listens ? kRetry_ms : kSilence_ms);
    if (entries[1].revents != 0) hear();
    const std::lock_guard lock(mutex_);
    if (ending_) return;
    if (ready == 0) tell_all(": still here\n\n");
  }
}

}  // namespace ldp::gallery
