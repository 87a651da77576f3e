#include "device/tool/session.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>

#include "device/tool/process/progress_bar.h"

namespace ldp {

bool is_machine_fault(const std::error_code& code) {
  constexpr std::array kFaults{std::errc::no_space_on_device,      std::errc::io_error,
                               std::errc::not_enough_memory,       std::errc::resource_unavailable_try_again,
                               std::errc::too_many_files_open,     std::errc::too_many_files_open_in_system,
                               std::errc::read_only_file_system,   std::errc::timed_out,
                               std::errc::device_or_resource_busy, std::errc::no_such_device,
                               std::errc::no_buffer_space};
  const auto is_this = [&](std::errc fault) { return code == fault; };
  const bool beyond_posix = code.category() == std::generic_category() || code.category() == std::system_category()
                                ? code.value() == EDQUOT || code.value() == ESTALE
                                : false;
  return beyond_posix || std::any_of(kFaults.begin(), kFaults.end(), is_this);
}

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
