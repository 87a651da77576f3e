// What a long-running stage needs from its caller besides its inputs: threads, a way to be stopped, a way to tell how
// far it is. Results never depend on `threads`.
#pragma once

#include <functional>
#include <stdexcept>
#include <stop_token>
#include <string_view>

namespace ldp {

// Thrown by a stage when its job's stop token was triggered.
struct Cancelled : std::runtime_error {
  Cancelled() : std::runtime_error("cancelled") {}
};

// Thrown when the input is sound but the job cannot be done with it (too few frames, nothing overlaps). Exit status 1.
struct Impossible : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Job {
  int threads = 1;
  std::stop_token stop;
  std::function<void(std::string_view stage, double fraction)>
      progress;                                       // may be empty; called from one thread at a time
  std::function<void(std::string_view text)> remark;  // likewise: what a person should hear before the job ends

  void check() const {
    if (stop.stop_requested()) throw Cancelled();
  }
  void report(std::string_view stage, double fraction) const {
    check();
    if (progress) progress(stage, fraction);
  }
};

// Runs body(i) for i in [0, count), in no order, on job.threads threads or as many as there is room for; rethrows the
// first exception (by index). Checks job.stop between items. `body` must write only to places of item i.
void parallel_for(const Job& job, int count, const std::function<void(int)>& body);

}  // namespace ldp
