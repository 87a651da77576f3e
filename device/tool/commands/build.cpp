// ldp build: a capture to an .ldp file.

#include "core/pipeline/build.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/base/memory/large_arrays.h"
#include "core/base/processor_time.h"
#include "core/captures/json_text.h"
#include "core/panorama/file/ldp_file.h"
#include "core/verdict/words.h"
#include "device/tool/build_setup.h"
#include "device/tool/commands.h"
#include "device/tool/commands/build_report.h"
#include "device/tool/commands/follow_capture.h"
#include "device/tool/json/quality_json.h"
#include "device/tool/many/estimate_command.h"
#include "device/tool/many/recipe.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/process/progress_bar.h"
#include "device/tool/switches.h"

namespace ldp {
namespace {

struct BuildCommand {
  BuildSetup setup;
  std::string output, report, debug;
  bool follow = false, strict = false, if_needed = false, estimate = false;
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
  const size_t layers = panorama.layers.size();
  std::printf("%s: %dx%d, %zu %s, %zu of %zu photos, %zu bytes, %.1f s\n", printable(command.output).c_str(),
              panorama.grid.width, panorama.grid.height, layers, layers == 1 ? "layer" : "layers",
              panorama.cameras.size(), result.report.poses.frames.size(), bytes, seconds);
  print_left_out(result.report.poses);
  for (const std::string& note : with_switches(result.report.notes))
    std::fprintf(stderr, "ldp build: %s\n", printable(note).c_str());
  std::printf("%s\n", text_of(result.report.quality).c_str());
}

// The exit status. The file is written all the same: it may be all there is of the place.
int judged(const BuildCommand& command, const SweepQuality& quality) {
  if (!command.strict || quality.grade != Grade::sweep_again) return kDone;
  std::fprintf(stderr, "ldp build: %s: %s (--strict)\n", printable(command.output).c_str(), text_of(quality).c_str());
  return kCannotBeDone;
}

// Of pipes (/dev/stdout) the names alone tell.
bool is_same_place(const std::string& a, const std::string& b) {
  std::error_code of_a, of_b;
  const auto place = std::filesystem::weakly_canonical(a, of_a), other = std::filesystem::weakly_canonical(b, of_b);
  return of_a || of_b ? a == b : place == other;
}

void check_outputs(const BuildCommand& command) {
  if (command.output.empty())
    throw BadInput("-o FILE.ldp is missing or empty: name the panorama to write, such as: ldp build " +
                   in_shell(command.setup.captures) + " -o room.ldp");
  check_output_file(command.output, OutputKind::panorama);
  if (command.report.empty()) return;
  if (is_same_place(command.report, command.output))
    throw BadInput(command.report + ": is named for the panorama and for the report: choose two names");
  check_output_file(command.report, OutputKind::report);
}

void check_estimate(const BuildCommand& command) {
  if (!command.report.empty())
    throw BadInput(
        "--estimate builds nothing that --report could tell of: leave that out, or keep the estimate by --json > " +
        in_shell({command.report}));
  if (!command.debug.empty())
    throw BadInput("--estimate builds nothing that --debug could draw: leave one of them out");
}

// One to /dev/null, or to a pipe, told whoever wanted to know.
bool tells_of_success(const std::string& report) {
  const std::filesystem::file_status status = std::filesystem::status(report);
  if (!std::filesystem::is_regular_file(status)) return std::filesystem::exists(status);
  return !nlohmann::json::parse(read_file(report), nullptr, false).contains("failure");
}

// The panorama that is there already where nothing needs to be done.
std::optional<LdpDescription> earlier(const BuildCommand& command, const std::string& recipe,
                                      const PreparedBuild& prepared, const Job& job) {
  if (!command.report.empty() && !tells_of_success(command.report)) return std::nullopt;
  return made_already(command.output, recipe, command.setup, prepared, job);
}

int tell_earlier(const BuildCommand& command, const LdpDescription& earlier, bool in_json) {
  const std::map<std::string, double>& figures = earlier.panorama.quality;
  if (in_json) {
    const nlohmann::ordered_json json{
        {"file", command.output}, {"made_already", true}, {"quality", quality_json(figures)}};
    std::printf("%s\n", json_text(json, 1).c_str());
  } else {
    std::printf("%s: made already from the same photos and options\n", printable(command.output).c_str());
  }
  const std::optional<SweepQuality> quality = quality_from(figures);
  return quality ? judged(command, *quality) : kDone;
}

// A report of many builds tells of those that failed too.
void report_failure(const BuildCommand& command, const Failure& failure) {
  nlohmann::ordered_json report{{"version", LDP_VERSION},
                                {"failure", {{"status", failure.status}, {"text", failure.text}}}};
  report["options"]["capture"] = command.setup.capture();
  write_text(command.report, json_text(report, 1) + "\n");
}

int run(const BuildCommand& command, const Session& session) {
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  const RecycledArrays recycled;  // of photos that come in before the build, too
  PoseEstimator begun{PosesOptions{}};
  BuildSetup setup = command.setup;
  setup.trimmed = !command.follow;  // what all photos have is not known before the last of them
  if (command.follow) begun = follow_capture(setup, STDIN_FILENO, job);
  const auto begin = std::chrono::steady_clock::now();
  setup.scratch = std::filesystem::absolute(command.output).parent_path().string();
  PreparedBuild prepared = prepare(setup, job);
  const std::string recipe = command.if_needed ? recipe_of(command.setup, prepared) : "";
  keep_out_of_capture(command.debug, "--debug", prepared);
  if (command.if_needed)
    if (const auto there = earlier(command, recipe, prepared, job)) return tell_earlier(command, *there, session.json);
  prepared.options.scratch_directory = setup.scratch;
  BuildResult result = build_with_pictures(prepared, command.debug, job, std::move(begun));
  add_metadata(prepared.notes, result.panorama);
  if (command.if_needed) result.panorama.metadata[kRecipe] = recipe;
  const int colour_quality = command.setup.colour_quality.value_or(result.colour_quality);
  const std::vector<uint8_t> file = encode_ldp(result.panorama, {colour_quality}, job);
  write_output(command.output, file);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  nlohmann::ordered_json report = report_json(result.report, result.panorama);
  report["version"] = LDP_VERSION;
  report["options"] = options_json(command.setup, prepared.options);
  report["options"]["colour_quality"] = colour_quality;
  report["options"]["threads"] = session.thread_count();
  report["seconds"]["whole"] = seconds;
  report["processor_seconds"]["whole"] = processor_seconds();
  report["peak_memory_bytes"] = peak_memory_bytes();
  report["scratch_files"] = result.scratch != nullptr;
  report["bytes"] = sizes_json(file);
  if (!command.report.empty()) write_text(command.report, json_text(report, 1) + "\n");
  bar.reset();
  if (session.json)
    std::printf("%s\n", json_text(report, 1).c_str());
  else
    print_summary(command, result, file.size(), seconds);
  return judged(command, result.report.quality);
}

}  // namespace

void add_build(Program& program) {
  auto command = std::make_shared<BuildCommand>();
  CLI::App& app =
      add_command(program, "build", "Turn the photos of a sweep, or a film of it, into a layered depth panorama",
                  [command, &program](const Session& session) {
                    check_names(command->setup);
                    if (command->estimate) {
                      check_estimate(*command);
                      return tell_estimate(command->setup, command->output, session);
                    }
                    check_outputs(*command);
                    if (!command->report.empty())
                      program.failed = [command](const Failure& failure) { report_failure(*command, failure); };
                    return run(*command, session);
                  });
  add_capture_options(app, command->setup);
  app.add_option("-o,--output", command->output, "The .ldp file to write; only --estimate does without");
  add_build_options(app, command->setup);
  app.add_flag("--follow", command->follow,
               "Begin while CAPTURE is being taken: the name of each photo, once it is stored, as a line on standard "
               "input, then 'end'")
      ->excludes("--cameras");
  app.add_flag("--strict", command->strict, "Exit with status 1 when the verdict is 'sweep again'; the file is kept");
  app.add_flag(
         "--if-needed", command->if_needed,
         "Do nothing if the .ldp file is sound, no input is newer, and it was made so, with --if-needed too, from the "
         "same photos with the same options")
      ->excludes("--follow");
  app.add_flag(
         "--estimate", command->estimate,
         "Tell roughly the processor seconds, memory and bytes of the file before the work, and build nothing; takes "
         "a tenth to two fifths of it, more of small photos")
      ->excludes("--follow");
  app.add_option("--report", command->report, "Write seconds, memory, energies and sizes to this .json file");
  app.add_option("--debug", command->debug, "Write pictures of every stage into this folder")->excludes("--if-needed");
}

}  // namespace ldp
