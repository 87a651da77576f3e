// Tasks of which some wait for others. A thread that is free takes the first task that waits for nothing more, so that
// threads stand idle only where the order itself leaves them nothing to do. If tasks that touch the same data always
// wait for each other, no result depends on timing.
#pragma once

#include <functional>
#include <vector>

#include "core/base/job.h"

namespace ldp {

class TaskOrder {
 public:
  using Task = int;

  // Adds a task that waits for others, all added before.
  Task add(std::function<void()> work, const std::vector<Task>& waits_for);

  // Does all tasks, once, on job.threads threads; checks job.stop before each. Rethrows the exception of the first task
  // that threw one; tasks not begun by then are left.
  void run(const Job& job);

 private:
  struct Entry {
    std::function<void()> work;
    std::vector<Task> followers;
    int waits = 0;
  };
  std::vector<Entry> tasks_;
};

}  // namespace ldp
