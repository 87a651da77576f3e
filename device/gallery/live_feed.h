// What the device tells, sent on to every browser that has the live page open (server-sent events, WHATWG HTML 9.2):
// one thread for all of them. A follower that does not read is let go; browsers come back on their own.
#pragma once

#include <array>
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
  // nullptr: there is no device; followers then hear that they are connected, no more.
  explicit LiveFeed(std::unique_ptr<StatusListener> listener);
  ~LiveFeed();

  bool has_device() const { return listener_ != nullptr; }
  // A socket to which the head of the answer was written. Closed if there are too many.
  void add(UniqueFd follower);
  // To the device. Throws std::runtime_error.
  void send(Command command);

 private:
  void run();
  void hear();
  void tell_all(const std::string& event);
  void wake() const;

  std::unique_ptr<StatusListener> listener_;
  UniqueFd wake_;
  std::mutex mutex_;  // of what follows
  bool ending_ = false;
  std::vector<UniqueFd> followers_;
  std::array<std::string, 4> last_;  // event of each kind of message, for those who come later
  std::thread thread_;
};

}  // namespace ldp::gallery
