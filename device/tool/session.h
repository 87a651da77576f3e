// What every command shares: the common options, a job that Ctrl-C stops, and exit statuses.
#pragma once

#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>

#include "core/base/job.h"

namespace ldp {

// 70 and 75 are those of sysexits.h: an internal error, and a machine at fault, on which another time may go better.
enum ExitStatus : int {
  kDone = 0,
  kCannotBeDone = 1,
  kBadInput = 2,
  kInternalError = 70,
  kTryAgain = 75,
  kInterrupted = 130
};

// The user asked for something that cannot be meant, or gave something that cannot be read. Exit status 2.
struct BadInput : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The machine let the job down: a full disk, say. Exit status 75.
struct MachineFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Whether a system call failed for want of something that another machine, or another time, may have: room, memory,
// descriptors, a disk that answers. What was named wrongly, or may not be used, is not that.
bool is_machine_fault(const std::error_code& code);

// Such a fault in the words of another program.
std::optional<std::error_code> machine_fault_in(std::string_view said);

// The same words, and what to do where they tell of a full disk.
std::string with_remedy(std::string said);

// What it says, for people: std::filesystem's own text names its functions.
std::string words_of(const std::system_error& error);

class ProgressBar;

struct Session {
  int threads = 0;       // 0 = one per processor
  bool json = false;     // machine-readable output on stdout
  int progress_fd = -1;  // lines "FRACTION STAGE" for a parent process (progress_bar.h); -1 = none
  std::stop_token stop;

  int thread_count() const;
};

// A job of this session. The bar must live as long as the job is used.
Job start_job(const Session& session, ProgressBar& bar);

}  // namespace ldp
