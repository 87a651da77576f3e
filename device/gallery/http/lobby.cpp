#include "device/gallery/http/lobby.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <initializer_list>
#include <string_view>
#include <system_error>

#include "device/gallery/http/server_tuning.h"
#include "drivers/interface/clocks.h"

namespace ldp::gallery {
namespace {

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

bool is_one_of(std::initializer_list<int> known, int error) {
  return std::find(known.begin(), known.end(), error) != known.end();
}
bool is_of_one_connection(int error) { return is_one_of({EAGAIN, EINTR, ECONNABORTED, EPROTO}, error); }
bool is_over_when_others_end(int error) { return is_one_of({EMFILE, ENFILE, ENOBUFS, ENOMEM, EPERM}, error); }

enum class Head { partial, whole, too_long, gone };

// What has come so far, left where it is.
Head head_at(int connection) {
  std::array<char, kMostHeadBytes> bytes;
  const ssize_t got = ::recv(connection, bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  if (got < 0) return errno == EAGAIN || errno == EINTR ? Head::partial : Head::gone;
  if (got == 0) return Head::gone;
  const std::string_view head(bytes.data(), static_cast<size_t>(got));
  if (head.find("\r\n\r\n") != std::string_view::npos) return Head::whole;
  return head.size() == bytes.size() ? Head::too_long : Head::partial;
}

void refuse_long_head(int connection) {
  constexpr std::string_view kWords =
      "HTTP/1.1 431 Request Header Fields Too Large\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
  ::send(connection, kWords.data(), kWords.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace

Lobby::Lobby(int listening, int end) : listening_(listening), end_(end), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
  if (!epoll_.is_open()) fail("cannot make an epoll descriptor");
  if (!watch(listening_, EPOLLIN) || !watch(end_, EPOLLIN)) fail("cannot wait for connections");
}

bool Lobby::watch(int fd, uint32_t events) const {
  epoll_event event{};
  event.events = events;
  event.data.fd = fd;
  return ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) == 0;
}

void Lobby::admit(UniqueFd connection) {
  const int fd = connection.get();
  const std::lock_guard lock(mutex_);
  if (guests_.size() >= kMostWaiting) return;
  const auto guest =
      guests_.insert_or_assign(fd, Guest{std::move(connection), monotonic_now_ns() + kHeadWithin_ms * kMillisecond_ns});
  if (!watch(fd, EPOLLIN | EPOLLRDHUP | EPOLLET)) guests_.erase(guest.first);  // the kernel has no room: it is closed
}

void Lobby::accept_all() {
  for (;;) {
    UniqueFd connection(::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!connection.is_open()) break;
    const int on = 1, bytes = kSendBuffer;
    ::setsockopt(connection.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    ::setsockopt(connection.get(), SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
    admit(std::move(connection));
  }
  if (is_of_one_connection(errno)) return;
  if (!is_over_when_others_end(errno)) fail("cannot accept connections");
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, listening_, nullptr);  // the client that waits would wake us at once
  deaf_until_ns_ = monotonic_now_ns() + kShortage_ms * kMillisecond_ns;
}

void Lobby::listen_again() {
  if (deaf_until_ns_ == 0 || monotonic_now_ns() < deaf_until_ns_) return;
  deaf_until_ns_ = watch(listening_, EPOLLIN) ? 0 : monotonic_now_ns() + kShortage_ms * kMillisecond_ns;
}

void Lobby::look_at(int fd, std::vector<UniqueFd>& ready) {
  const std::lock_guard lock(mutex_);
  const auto guest = guests_.find(fd);
  if (guest == guests_.end()) return;
  const Head head = head_at(fd);
  if (head == Head::partial) return;
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, fd, nullptr);
  if (head == Head::whole) ready.push_back(std::move(guest->second.connection));
  if (head == Head::too_long) refuse_long_head(fd);
  guests_.erase(guest);
}

void Lobby::send_away_late() {
  const int64_t now_ns = monotonic_now_ns();
  if (now_ns - looked_ns_ < kLateEvery_ms * kMillisecond_ns) return;
  looked_ns_ = now_ns;
  const std::lock_guard lock(mutex_);
  std::erase_if(guests_, [&](const auto& guest) { return guest.second.until_ns < now_ns; });  // closing ends the watch
}

std::vector<UniqueFd> Lobby::next() {
  std::array<epoll_event, 64> events;
  const int wait_ms = deaf_until_ns_ == 0 ? kLateEvery_ms : kShortage_ms;
  const int count = ::epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), wait_ms);
  if (count < 0 && errno != EINTR) fail("cannot wait for connections");
  std::vector<UniqueFd> ready;
  for (int i = 0; i < count; ++i) {
    const int fd = events[static_cast<size_t>(i)].data.fd;
    if (fd == end_)
      has_ended_ = true;
    else if (fd == listening_)
      accept_all();
    else
      look_at(fd, ready);
  }
  send_away_late();
  listen_again();
  return ready;
}

}  // namespace ldp::gallery
