#include "core/base/task_order.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>

namespace ldp {

TaskOrder::Task TaskOrder::add(std::function<void()> work, const std::vector<Task>& waits_for) {
  const auto task = static_cast<Task>(tasks_.size());
  tasks_.push_back({std::move(work), {}, static_cast<int>(waits_for.size())});
  for (const Task before : waits_for) tasks_[static_cast<size_t>(before)].followers.push_back(task);
  return task;
}

void TaskOrder::run(const Job& job) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Task> ready;  // a heap, the first task on top; its room is taken here so that nothing throws later
  ready.reserve(tasks_.size());
  size_t left = tasks_.size();
  std::exception_ptr failure;
  auto failed = static_cast<Task>(left);
  for (size_t i = 0; i < tasks_.size(); ++i)
    if (tasks_[i].waits == 0) ready.push_back(static_cast<Task>(i));  // in order, so a heap

  const auto finish = [&](const Entry& done) {
    --left;
    for (const Task follower : done.followers)
      if (--tasks_[static_cast<size_t>(follower)].waits == 0) {
        ready.push_back(follower);
        std::push_heap(ready.begin(), ready.end(), std::greater<>());
      }
  };
  const auto work = [&](int) {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [&] { return !ready.empty() || left == 0 || failure; });
      if (left == 0 || failure) return;
      std::pop_heap(ready.begin(), ready.end(), std::greater<>());
      const Task task = ready.back();
      ready.pop_back();
      const Entry& entry = tasks_[static_cast<size_t>(task)];
      lock.unlock();
      std::exception_ptr thrown;
      try {
        job.check();
        entry.work();
      } catch (...) {
        thrown = std::current_exception();
      }
      lock.lock();
      if (!thrown) {
        finish(entry);
      } else if (task < failed) {
        failed = task;
        failure = thrown;
      }
      changed.notify_all();
    }
  };
  parallel_for(job, std::min(std::max(1, job.threads), static_cast<int>(tasks_.size())), work);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace ldp
