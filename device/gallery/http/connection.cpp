#include "device/gallery/http/connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/interface/clocks.h"

namespace ldp::gallery {
namespace {

bool await(int fd, short what, int64_t wait_ms) {
  pollfd entry{fd, what, 0};
  int ready = -1;
  do ready = ::poll(&entry, 1, static_cast<int>(std::max<int64_t>(0, wait_ms)));
  while (ready < 0 && errno == EINTR);
  return ready > 0;
}

}  // namespace

bool Connection::is_readable() const { return has_more() || await(socket_.get(), POLLIN, 0); }

bool Connection::is_writable() const { return socket_.is_open() && await(socket_.get(), POLLOUT, 0); }

void Connection::begin_request() {
  head_until_ns_ = monotonic_now_ns() + kHeadWithin_ms * kMillisecond_ns;
  head_bytes_ = 0;
  written_ = waited_ns_ = 0;
}

bool Connection::fill() {
  const int64_t left_ms = (head_until_ns_ - monotonic_now_ns()) / kMillisecond_ns;
  if (!await(socket_.get(), POLLIN, left_ms)) return false;
  const ssize_t got = ::recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
  begin_ = 0;
  end_ = got > 0 ? static_cast<size_t>(got) : 0;
  return got > 0;
}

ssize_t Connection::read(char* bytes, size_t size) {
  if (begin_ == end_ && !fill()) return 0;
  const size_t count = std::min(size, end_ - begin_);
  head_bytes_ += count;
  if (head_bytes_ > kMostHeadBytes) return -1;
  std::memcpy(bytes, buffer_.data() + begin_, count);
  begin_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t Connection::write(const char* bytes, size_t size) {
  for (size_t sent = 0; sent < size;) {
    const ssize_t count = ::send(socket_.get(), bytes + sent, size - sent, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count > 0) {
      sent += static_cast<size_t>(count);
      written_ += count;
      continue;
    }
    if (errno != EAGAIN && errno != EINTR) return -1;
    const int64_t patience_ns = (kUnreadFor_ms + written_ / kLeastBytesPer_ms) * kMillisecond_ns;
    const int64_t begin_ns = monotonic_now_ns();
    const bool reads = await(socket_.get(), POLLOUT, (patience_ns - waited_ns_) / kMillisecond_ns);
    waited_ns_ += monotonic_now_ns() - begin_ns;
    if (!reads) return -1;
  }
  return static_cast<ssize_t>(size);
}

void Connection::say_goodbye() {
  if (!socket_.is_open()) return;
  ::shutdown(socket_.get(), SHUT_WR);
  const int64_t until_ns = monotonic_now_ns() + kGoodbye_ms * kMillisecond_ns;
  for (int64_t now = 0; (now = monotonic_now_ns()) < until_ns;) {
    if (!await(socket_.get(), POLLIN, (until_ns - now) / kMillisecond_ns)) return;
    if (::recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT) <= 0) return;
  }
}

}  // namespace ldp::gallery
