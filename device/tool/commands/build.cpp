// ldp build: a capture folder to an .ldp file.

#include "core/pipeline/build.h"
#include "core/photos/left_out.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/panorama/file/ldp_file.h"
#include "core/verdict/words.h"
#include "device/tool/build_setup.h"
#include "device/tool/commands.h"
#include "device/tool/commands/build_report.h"
#include "device/tool/commands/follow_capture.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/process/progress_bar.h"
#include "device/tool/switches.h"

namespace ldp {
namespace {

struct BuildCommand {
  BuildSetup setup;
  std::string output, report, debug;
  bool follow = false, strict = false;
};

// Debug pictures stay also when the build cannot be done: that is when they are wanted most. An interrupted one leaves
// none.
BuildResult build_with_pictures(const PreparedBuild& prepared, const std::string& debug, const Job& job,
                                PoseEstimator begun) {
  if (debug.empty()) return build(prepared.frames, prepared.options, job, std::move(begun));
  OutputFolder folder(debug, OutputFolder::Existing::merge);
  BuildOptions options = prepared.options;
  options.debug_directory = folder.path().string();
  try {
    BuildResult result;
    folder.fill([&] { result = build(prepared.frames, options, job, std::move(begun)); });
    folder.keep();
    return result;
  } catch (const Cancelled&) {
    throw;
  } catch (...) {
    folder.keep();
    throw;
  }
}

void add_metadata(const CaptureNotes& notes, LayeredPanorama& panorama) {
  panorama.metadata["software"] = "ldp " LDP_VERSION;
  if (!notes.device.empty()) panorama.metadata["device"] = notes.device;
  if (!notes.captured_utc.empty()) panorama.metadata["captured_utc"] = notes.captured_utc;
}

void print_summary(const BuildCommand& command, const BuildResult& result, size_t bytes, double seconds) {
  const LayeredPanorama& panorama = result.panorama;
  std::printf("%s: %dx%d, %zu layers, %zu of %zu photos, %zu bytes, %.1f s\n", command.output.c_str(),
              panorama.grid.width, panorama.grid.height, panorama.layers.size(), panorama.cameras.size(),
              result.report.poses.frames.size(), bytes, seconds);
  for (const FrameReport& frame : result.report.poses.frames) {
    if (!frame.posed) std::printf("%s: left out: %s\n", frame.name.c_str(), words_of(frame.left_out).c_str());
  }
  for (const std::string& note : with_switches(result.report.notes))
    std::fprintf(stderr, "ldp build: %s\n", note.c_str());
  std::printf("%s\n", text_of(result.report.quality).c_str());
}

// The file is written all the same: it may be all there is of the place.
void refuse_poor_quality(const BuildCommand& command, const SweepQuality& quality) {
  if (command.strict && quality.grade == Grade::sweep_again)
    throw Impossible(command.output + ": " + text_of(quality) + " (--strict)");
}

int run(const BuildCommand& command, const Session& session) {
  check_output_file(command.output, OutputKind::panorama);
  if (std::filesystem::weakly_canonical(command.report) == std::filesystem::weakly_canonical(command.output))
    throw BadInput(command.report + ": is named for the panorama and for the report: choose two names");
  if (!command.report.empty()) check_output_file(command.report, OutputKind::report);
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  PoseEstimator begun{PosesOptions{}};
  if (command.follow) begun = follow_capture(command.setup, STDIN_FILENO, job);
  const auto begin = std::chrono::steady_clock::now();
  PreparedBuild prepared = prepare(command.setup);
  prepared.options.scratch_directory = std::filesystem::absolute(command.output).parent_path().string();
  BuildResult result = build_with_pictures(prepared, command.debug, job, std::move(begun));
  add_metadata(prepared.notes, result.panorama);
  const std::vector<uint8_t> file = encode_ldp(result.panorama, {command.setup.colour_quality}, job);
  write_output(command.output, file);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  nlohmann::ordered_json report = report_json(result.report, result.panorama);
  report["version"] = LDP_VERSION;
  report["options"] = options_json(command.setup, prepared.options);
  report["options"]["threads"] = session.thread_count();
  report["seconds"]["whole"] = seconds;
  report["peak_memory_bytes"] = peak_memory_bytes();
  report["scratch_files"] = result.scratch != nullptr;
  report["bytes"] = sizes_json(file);
  if (!command.report.empty()) write_text(command.report, report.dump(1) + "\n");
  bar.reset();
  if (session.json)
    std::printf("%s\n", report.dump(1).c_str());
  else
    print_summary(command, result, file.size(), seconds);
  refuse_poor_quality(command, result.report.quality);
  return kDone;
}

}  // namespace

void add_build(Program& program) {
  auto command = std::make_shared<BuildCommand>();
  CLI::App& app = add_command(program, "build", "Turn a folder of photos into a layered depth panorama",
                              [command](const Session& session) { return run(*command, session); });
  add_capture_options(app, command->setup);
  app.add_option("-o,--output", command->output, "The .ldp file to write")->required();
  add_build_options(app, command->setup);
  app.add_flag("--follow", command->follow,
               "Begin while CAPTURE is being taken: the name of each photo, once it is stored, as a line on standard "
               "input, then 'end'")
      ->excludes("--cameras");
  app.add_flag("--strict", command->strict, "Exit with status 1 when the verdict is 'sweep again'; the file is kept");
  app.add_option("--report", command->report, "Write seconds, memory, energies and sizes to this .json file");
  app.add_option("--debug", command->debug, "Write pictures of every stage into this folder");
}

}  // namespace ldp
