#include "device/tool/process/interrupt.h"

#include <unistd.h>
#include <csignal>
#include <ctime>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

#include "device/tool/session.h"

namespace ldp {
namespace {

// What has to go when the program is cut off. The one piece of state that must be reachable from everywhere.
struct Registry {
  std::recursive_mutex mutex;  // a finishing thread may still register and forget
  std::vector<const WhenCutOff*> clean_ups;
  std::atomic<int> unhurried = 0;
  std::string who;  // is interrupted; empty where nobody is to be told of it
  bool written = false;
};

Registry& registry() {
  static auto* const alive_for_ever = new Registry;  // still there when static objects are destroyed
  return *alive_for_ever;
}

sigset_t ending_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  return set;
}

timespec timespec_of(std::chrono::milliseconds time) {
  return {static_cast<time_t>(time.count() / 1000), static_cast<long>(time.count() % 1000) * 1'000'000};
}

}  // namespace

void say_when_interrupted(const std::string& who) {
  const std::lock_guard lock(registry().mutex);
  registry().who = who;
}

std::string take_interrupted_line() {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  const std::string who = std::exchange(all.who, {});
  if (who.empty()) return {};
  return who + ": interrupted: " + (all.written ? "what was written before is whole" : "nothing was written") + "\n";
}

void note_written() {
  const std::lock_guard lock(registry().mutex);
  registry().written = true;
}

bool is_anything_written() {
  const std::lock_guard lock(registry().mutex);
  return registry().written;
}

void cut_off(int status, const std::string& line) {
  // The lock is kept: nobody may register or write anything from here on.
  Registry& all = registry();
  all.mutex.lock();
  for (const WhenCutOff* const clean_up : all.clean_ups) (*clean_up)();
  std::string last = ::isatty(STDERR_FILENO) == 1 ? "\r\x1b[K" : "";  // over a progress bar
  last += line;
  if (!last.empty() && ::write(STDERR_FILENO, last.data(), last.size()) < 0) ::_exit(status);
  ::_exit(status);
}

Interrupt::Interrupt() {
  const sigset_t set = ending_signals();
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  waiter_ = std::jthread([this](const std::stop_token& over) { wait(over); });
}

Interrupt::~Interrupt() {
  waiter_.request_stop();
  // It is blocked in every thread, and ends no more than the wait.
  ::pthread_kill(waiter_.native_handle(), SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
}

void Interrupt::wait(const std::stop_token& over) {
  const sigset_t set = ending_signals();
  int signal = 0;
  ::sigwait(&set, &signal);
  if (over.stop_requested()) return;
  stop_.request_stop();
  const timespec patience = timespec_of(kPatience);
  // A second Ctrl-C is the end of patience; the destructor's, of everything.
  while (::sigtimedwait(&set, nullptr, &patience) < 0 && registry().unhurried > 0) {
  }
  const std::lock_guard lock(registry().mutex);  // no result takes its name between what is told and the end
  if (!over.stop_requested()) cut_off(kInterrupted, take_interrupted_line());
}

Finishing::Finishing() {
  registry().mutex.lock();
  note_written();
}
Finishing::~Finishing() { registry().mutex.unlock(); }

WhenCutOff::WhenCutOff(std::function<void()> clean_up) : clean_up_(std::move(clean_up)) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.clean_ups.push_back(this);
}

WhenCutOff::~WhenCutOff() {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.clean_ups.erase(std::find(all.clean_ups.begin(), all.clean_ups.end(), this));
}

// A worker may still be writing into the folder: once more takes what came in between.
Temporary::Temporary(std::filesystem::path path)
    : removal_([path = std::move(path)] {
        std::error_code ignored;
        for (int attempt = 0; attempt < 3; ++attempt) std::filesystem::remove_all(path, ignored);
      }) {}

Unhurried::Unhurried() {
  note_written();
  ++registry().unhurried;
}
Unhurried::~Unhurried() { --registry().unhurried; }

}  // namespace ldp
