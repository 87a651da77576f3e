// What the device tells, sent on to every browser that has the live page open (server-sent events, WHATWG HTML 9.2):
// one thread for all of them. A follower that does not read is let go; browsers come back on their own. The connection
// to the device is opened again where it is missing or has ended (a network that comes up late): told once on the log.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/interface/status.h"
#include "drivers/interface/unique_fd.h"

namespace ldp::gallery {

class LiveFeed {
 public:
  using Open = std::function<std::unique_ptr<StatusListener>()>;  // throws std::runtime_error where it cannot

  // Empty: there is no device; followers then hear that they are connected, no more.
  explicit LiveFeed(Open open);
  ~LiveFeed();

  bool has_device() const { return static_cast<bool>(open_); }
  // A socket to which the head of the answer was written. Closed if there are too many.
  void add(UniqueFd follower);
  // To the device. Throws std::runtime_error.
  void send(Command command);

 private:
  void run();
  void open_missing();
  void hear();
  void tell_all(const std::string& event);
  void wake() const;

  const Open open_;
  UniqueFd wake_;
  int64_t next_try_ns_ = 0;  // of the thread alone, as the next
  std::string problem_;      // as it was told last
  std::mutex mutex_;         // of what follows
  std::unique_ptr<StatusListener> listener_;
  bool ending_ = false;
  std::vector<UniqueFd> followers_;
  std::array<std::string, 4> last_;  // event of each kind of message, for those who come later
  std::thread thread_;
};

}  // namespace ldp::gallery
