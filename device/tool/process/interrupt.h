// Ctrl-C: asks running work to stop, and ends the program by force when that takes too long.
//
// SIGINT, SIGTERM and SIGHUP are waited for on a thread of their own. Work that does not stop within kPatience is cut
// off: temporary files and folders registered here are removed first, so that nothing partial stays behind. A second
// signal cuts off at once. Standard error is told in one line whether any result is there.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
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

// From now on an interruption is told: "ldp build", in a line that begins so.
void say_when_interrupted(const std::string& who);

// That line, with its end, for whoever is first to write it; empty for all others.
std::string take_interrupted_line();

// A result is about to be there: it is no longer told that nothing was written.
void note_written();
bool is_anything_written();

// Does what is registered here and ends the program, from any thread, whatever else runs; `line` goes to standard
// error.
[[noreturn]] void cut_off(int status, const std::string& line);

// While one is alive, being cut off calls it, on another thread; it must not throw.
class WhenCutOff {
 public:
  explicit WhenCutOff(std::function<void()> clean_up);
  ~WhenCutOff();
  WhenCutOff(const WhenCutOff&) = delete;
  WhenCutOff& operator=(const WhenCutOff&) = delete;
  void operator()() const { clean_up_(); }

 private:
  std::function<void()> clean_up_;
};

// A path that must not outlive an interrupted program. While one is alive, being cut off removes it.
class Temporary {
 public:
  explicit Temporary(std::filesystem::path path);

 private:
  WhenCutOff removal_;
};

// While one is alive the first signal asks only: work that stores what it has, piece by piece, takes the time that
// takes.
class Unhurried {
 public:
  Unhurried();
  ~Unhurried();
  Unhurried(const Unhurried&) = delete;
  Unhurried& operator=(const Unhurried&) = delete;
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
