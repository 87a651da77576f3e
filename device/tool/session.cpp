#include "device/tool/session.h"

#include <algorithm>
#include <thread>

#include "device/tool/process/progress_bar.h"

namespace ldp {

int Session::thread_count() const {
  return threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

Job start_job(const Session& session, ProgressBar& bar) {
  Job job;
  job.threads = session.thread_count();
  job.stop = session.stop;
  job.progress = [&bar](std::string_view stage, double fraction) { bar.show(stage, fraction); };
  return job;
}

}  // namespace ldp
