#include "device/service/events/service_notice.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "drivers/interface/unique_fd.h"

namespace ldp {

ServiceNotice::ServiceNotice() {
  if (const char* const socket = std::getenv("NOTIFY_SOCKET")) socket_ = socket;
  const char* const usec = std::getenv("WATCHDOG_USEC");
  const char* const pid = std::getenv("WATCHDOG_PID");
  const bool ours = pid == nullptr || std::atol(pid) == ::getpid();
  if (usec != nullptr && ours) watchdog_interval_ns_ = std::atoll(usec) * 1000 / 3;
}

void ServiceNotice::feed_watchdog(int64_t now_ns) {
  if (watchdog_interval_ns_ <= 0 || now_ns < next_feed_ns_) return;
  send("WATCHDOG=1");
  next_feed_ns_ = now_ns + watchdog_interval_ns_;
}

std::optional<int64_t> ServiceNotice::watchdog_deadline_ns() const {
  return watchdog_interval_ns_ > 0 ? std::optional(next_feed_ns_) : std::nullopt;
}

void ServiceNotice::send(const std::string& message) const {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_.empty() || socket_.size() >= sizeof address.sun_path) return;
  std::memcpy(address.sun_path, socket_.data(), socket_.size());
  if (socket_[0] == '@') address.sun_path[0] = '\0';  // the abstract name space
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_.size());
  const UniqueFd fd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!fd.is_open()) return;
  ::sendto(fd.get(), message.data(), message.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), length);
}

}  // namespace ldp
