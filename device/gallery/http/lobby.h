// Where connections wait until the whole head of a request is there, all in one thread: a client that sends a letter a
// second, or nothing, costs a descriptor and no more, and is sent away in time.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <vector>

#include "drivers/interface/unique_fd.h"

namespace ldp::gallery {

class Lobby {
 public:
  // `listening` and `end` are not its own. Throws std::system_error.
  Lobby(int listening, int end);

  // A connection that has been served waits for its next request. Any thread.
  void admit(UniqueFd connection);

  // Sleeps until something happens; connections whose request is there, nothing once `end` is readable (has_ended).
  // Throws std::system_error.
  std::vector<UniqueFd> next();
  bool has_ended() const { return has_ended_; }

 private:
  struct Guest {
    UniqueFd connection;
    int64_t until_ns = 0;
  };

  bool watch(int fd, uint32_t events) const;
  void accept_all();
  void listen_again();
  void look_at(int fd, std::vector<UniqueFd>& ready);
  void send_away_late();

  int listening_, end_;
  bool has_ended_ = false;
  int64_t looked_ns_ = 0;
  int64_t deaf_until_ns_ = 0;  // no room for one more connection; 0 = there is
  UniqueFd epoll_;
  std::mutex mutex_;  // of what follows
  std::map<int, Guest> guests_;
};

}  // namespace ldp::gallery
