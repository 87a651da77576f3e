// Ctrl-C: asks running work to stop, and ends the program by force when that takes too long.
//
// SIGINT, SIGTERM and SIGHUP are waited for on a thread of their own. Work that does not stop within kPatience is cut
// off: temporary files and folders registered here are removed first, so that nothing partial stays behind.
#pragma once

#include <chrono>
#include <filesystem>
#include <stop_token>
#include <string>
#include <thread>

namespace ldp {

constexpr std::chrono::milliseconds kPatience{150};

class Interrupt {
 public:
  Interrupt();  // blocks the signals in this thread and all it starts later
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  std::stop_token token() const { return stop_.get_token(); }
  bool came() const { return stop_.stop_requested(); }

 private:
  void wait(const std::stop_token& over);

  std::stop_source stop_;
  std::jthread waiter_;
};

// Removes all that is Temporary and ends the program, from any thread, whatever else runs; `line` goes to standard
// error.
[[noreturn]] void cut_off(int status, const std::string& line);

// A path that must not outlive an interrupted program. While one is alive, being cut off removes it.
class Temporary {
 public:
  explicit Temporary(std::filesystem::path path);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

 private:
  std::filesystem::path path_;
};

// While one is alive the program is not cut off: for the moment in which a finished result takes its name.
class Finishing {
 public:
  Finishing();
  ~Finishing();
  Finishing(const Finishing&) = delete;
  Finishing& operator=(const Finishing&) = delete;
};

}  // namespace ldp
