// Tells the world: the status channels by their URLs, opened as they come, left alone while they are gone. Whatever
// becomes of them, the capture goes on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device/service/events/poll_loop.h"
#include "drivers/interface/status.h"

namespace ldp {

class Announcer {
 public:
  explicit Announcer(const std::vector<std::string>& urls);  // opens those it can
  Announcer(const Announcer&) = delete;
  Announcer& operator=(const Announcer&) = delete;

  // Tries again those that could not be opened or have failed since. Each problem is told once.
  void open_missing();
  void publish(const StatusMessage& message);
  Watches watches(const std::function<void(Command)>& obey);  // for the commands that come in
  void tell_ignored(bool at_end);  // of malformed messages: when there are ten times as many, and at the end

 private:
  struct OpenChannel {
    std::string url;
    std::unique_ptr<StatusChannel> channel;
    bool failed = false;
  };
  struct PendingChannel {
    std::string url;
    std::string problem;  // as it was told last
  };

  void attempt(OpenChannel& open, const std::function<void(StatusChannel&)>& what);
  void serve(OpenChannel& open, const std::function<void(Command)>& obey);

  std::vector<OpenChannel> open_;
  std::vector<PendingChannel> pending_;
  int64_t ignored_told_ = 0;  // malformed messages, when they were last spoken of
};

}  // namespace ldp
