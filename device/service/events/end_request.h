// What asks a session to end: a stop token, or SIGTERM, SIGINT and SIGHUP; a descriptor either way.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "drivers/interface/unique_fd.h"

namespace ldp {

class EndRequest {
 public:
  // Listens to `stop`, or, where that can never ask, to the signals, which it then blocks in this thread and all that
  // start later: a thread that does not block them would be ended by them. Throws std::system_error.
  explicit EndRequest(std::stop_token stop);

  int fd() const { return fd_.get(); }  // readable when it was asked to end
  bool take();                          // one request; false if there is none
  bool waits() const;                   // to be taken

 private:
  UniqueFd fd_;
  std::optional<std::stop_callback<std::function<void()>>> on_stop_;
};

}  // namespace ldp
