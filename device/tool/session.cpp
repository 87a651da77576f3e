#include "device/tool/session.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <thread>

#include "device/tool/process/progress_bar.h"

namespace ldp {

namespace {

constexpr std::array kFaults{ENOSPC,    EIO,   ENOMEM, EAGAIN,  EMFILE, ENFILE, EROFS,
                             ETIMEDOUT, EBUSY, ENODEV, ENOBUFS, EDQUOT, ESTALE};

}  // namespace

bool is_machine_fault(const std::error_code& code) {
  const std::error_condition condition = code.default_error_condition();
  return condition.category() == std::generic_category() &&
         std::find(kFaults.begin(), kFaults.end(), condition.value()) != kFaults.end();
}

std::optional<std::error_code> machine_fault_in(std::string_view said) {
  for (const int fault : kFaults) {
    const std::error_code code(fault, std::generic_category());
    if (said.find(code.message()) != std::string_view::npos) return code;
  }
  return std::nullopt;
}

std::string with_remedy(std::string said) {
  for (const int full : {ENOSPC, EDQUOT})
    if (said.ends_with(std::generic_category().message(full))) said += ": free some space, or write elsewhere";
  return said;
}

std::string words_of(const std::system_error& error) {
  const auto* const of_files = dynamic_cast<const std::filesystem::filesystem_error*>(&error);
  if (of_files == nullptr || of_files->path1().empty()) return error.what();
  return "cannot use " + of_files->path1().string() + ": " + error.code().message();
}

int Session::thread_count() const {
  return threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

Job start_job(const Session& session, ProgressBar& bar) {
  Job job;
  job.threads = session.thread_count();
  job.stop = session.stop;
  job.progress = [&bar](std::string_view stage, double fraction) { bar.show(stage, fraction); };
  job.remark = [&bar](std::string_view text) { bar.remark(text); };
  return job;
}

}  // namespace ldp
