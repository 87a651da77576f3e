// What every command shares: the common options, a job that Ctrl-C stops, and exit statuses.
#pragma once

#include <stdexcept>
#include <stop_token>
#include <string>

#include "core/base/job.h"

namespace ldp {

enum ExitStatus : int { kDone = 0, kCannotBeDone = 1, kBadInput = 2, kInterrupted = 130 };

// The user asked for something that cannot be meant, or gave something that cannot be read. Exit status 2.
struct BadInput : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class ProgressBar;

struct Session {
  int threads = 0;       // 0 = one per processor
  bool json = false;     // machine-readable output on stdout
  int progress_fd = -1;  // lines "FRACTION STAGE" for a parent process; -1 = none
  std::stop_token stop;

  int thread_count() const;
};

// A job of this session. The bar must live as long as the job is used.
Job start_job(const Session& session, ProgressBar& bar);

}  // namespace ldp
