// The service manager's notification protocol (sd_notify(3)): a datagram to the socket named in NOTIFY_SOCKET.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ldp {

class ServiceNotice {
 public:
  ServiceNotice();  // reads NOTIFY_SOCKET and WATCHDOG_USEC; does nothing where they are absent

  void ready() { send("READY=1"); }
  void stopping() { send("STOPPING=1"); }
  // Asks for so much more time to end in, from now on.
  void still_stopping(int seconds) { send("EXTEND_TIMEOUT_USEC=" + std::to_string(seconds) + "000000"); }
  void status(const std::string& text) { send("STATUS=" + text); }

  // To be called at every turn of the loop; tells the watchdog in time that it turns.
  void feed_watchdog(int64_t now_ns);
  std::optional<int64_t> watchdog_deadline_ns() const;

 private:
  void send(const std::string& message) const;

  std::string socket_;
  int64_t watchdog_interval_ns_ = 0;  // 0 = none
  int64_t next_feed_ns_ = 0;
};

}  // namespace ldp
