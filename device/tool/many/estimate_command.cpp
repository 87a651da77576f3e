#include "device/tool/many/estimate_command.h"

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "core/estimate/estimate.h"
#include "device/tool/process/progress_bar.h"

namespace ldp {
namespace {

void print(const std::string& capture, const BuildEstimate& estimate) {
  std::printf("%s: about %.0f s of processor time, %.0f MB of memory", printable(capture).c_str(),
              estimate.processor_seconds, 1e-6 * static_cast<double>(estimate.memory_bytes));
  if (estimate.scratch_bytes > 0)
    std::printf(" and %.0f MB of temporary files", 1e-6 * static_cast<double>(estimate.scratch_bytes));
  std::printf(", a file of %.2f MB, %dx%d\n", 1e-6 * static_cast<double>(estimate.file_bytes), estimate.width,
              estimate.height);
}

}  // namespace

int tell_estimate(const BuildSetup& setup, const std::string& output, const Session& session) {
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  BuildSetup with_scratch = setup;
  with_scratch.scratch = std::filesystem::absolute(output.empty() ? "here" : output).parent_path().string();
  PreparedBuild prepared = prepare(with_scratch, job);
  prepared.options.scratch_directory = with_scratch.scratch;
  const BuildEstimate estimate = estimate_build(prepared.frames, prepared.options, setup.colour_quality, job);
  bar.reset();
  if (!session.json) {
    print(setup.capture(), estimate);
    return kDone;
  }
  const nlohmann::ordered_json json{{"capture", setup.capture()},
                                    {"processor_seconds", estimate.processor_seconds},
                                    {"memory_bytes", estimate.memory_bytes},
                                    {"scratch_bytes", estimate.scratch_bytes},
                                    {"file_bytes", estimate.file_bytes},
                                    {"width", estimate.width},
                                    {"height", estimate.height},
                                    {"spent_seconds", estimate.spent_seconds}};
  std::printf("%s\n", json_text(json, 1).c_str());
  return kDone;
}

}  // namespace ldp
