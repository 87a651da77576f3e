#include "core/base/job.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/memory/scratch_space.h"

namespace ldp {

void parallel_for(const Job& job, int count, const std::function<void(int)>& body) {
  std::atomic<int> next = 0;
  std::mutex mutex;
  int failed_index = count;
  std::exception_ptr failure;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        job.check();
        body(i);
        let_go_if_full();
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i < failed_index) {
          failed_index = i;
          failure = std::current_exception();
        }
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> others;
    const int threads = std::min(job.threads, count);
    try {
      for (int t = 1; t < threads; ++t) others.emplace_back(work);
    } catch (const std::exception&) {
      // The system has no room for one more: those that there are do the work.
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace ldp
