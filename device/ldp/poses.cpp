// ldp poses: the cameras of a capture, as transforms.json.

#include "poses.h"

#include <cstdio>
#include <memory>
#include <optional>

#include "build_report.h"
#include "build_setup.h"
#include "commands.h"
#include "output.h"
#include "progress_bar.h"
#include "transforms.h"

namespace ldp {
namespace {

struct PosesCommand {
  BuildSetup setup;
  std::string output;
};

void print_table(const PosesReport& report) {
  for (const FrameReport& frame : report.frames) {
    if (frame.posed) {
      std::printf("%s: %d features, %d matches, %d inliers, %.2f px\n", frame.name.c_str(), frame.features,
                  frame.matches, frame.inliers, frame.reprojection_px);
    } else {
      std::printf("%s: left out: %s\n", frame.name.c_str(), frame.reason.c_str());
    }
  }
  std::printf("%d points, %.2f px\n", report.points, report.reprojection_px);
  if (report.motion == Motion::rotation) std::printf("no parallax was found: the camera only turned\n");
}

int run(const PosesCommand& command, const Session& session) {
  if (!command.output.empty()) check_output_file(command.output);
  const PreparedBuild prepared = prepare(command.setup);
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  const Poses poses = prepared.options.cameras.empty()
                          ? estimate_poses(prepared.frames, prepared.options.poses, job)
                          : triangulate(prepared.frames, prepared.options.cameras, prepared.options.poses, job);
  job.check();
  if (!command.output.empty()) write_text(command.output, transforms_json(poses.cameras));
  bar.reset();
  if (session.json)
    std::printf("%s\n", poses_json(poses.report).dump(1).c_str());
  else
    print_table(poses.report);
  return kDone;
}

}  // namespace

void add_poses(Program& program) {
  auto command = std::make_shared<PosesCommand>();
  CLI::App& app = add_command(program, "poses", "Estimate the cameras of a folder of photos",
                              [command](const Session& session) { return run(*command, session); });
  add_capture_options(app, command->setup);
  app.add_option("-o,--output", command->output, "The transforms.json to write");
}

}  // namespace ldp
