// ldp poses: the cameras of a capture, as transforms.json and as a COLMAP model.

#include "core/poses/poses.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/arc/arc.h"
#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/captures/colmap.h"
#include "core/captures/json_text.h"
#include "core/captures/transforms.h"
#include "device/tool/build_setup.h"
#include "device/tool/commands.h"
#include "device/tool/commands/build_report.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/process/progress_bar.h"
#include "device/tool/switches.h"

namespace ldp {
namespace {

struct PosesCommand {
  BuildSetup setup;
  std::string output, colmap;
};

// What was found in frames of the working size, for the photos as they are stored.
void to_stored_size(const FolderFrames& frames, Poses& poses) {
  std::vector<Eigen::Array2d> corners, scales;  // by camera, in stored pixels; and stored pixels to one of the frame
  for (size_t i = 0; i < poses.cameras.size(); ++i) {
    const auto [stored, part, left, top] = frames.framing(poses.frame_of_camera[i]);
    const double sx = static_cast<double>(part.width) / frames.working_size().width,
                 sy = static_cast<double>(part.height) / frames.working_size().height;
    corners.emplace_back(left, top);
    scales.emplace_back(sx, sy);
    Intrinsics& k = poses.cameras[i].intrinsics;
    k.width = stored.width, k.height = stored.height;
    k.fx *= sx, k.cx = sx * k.cx + left, k.fy *= sy, k.cy = sy * k.cy + top;
  }
  for (size_t point = 0; point < poses.sightings.size(); ++point) {
    for (size_t i = 0; i < poses.sightings[point].size(); ++i) {
      const auto camera = static_cast<size_t>(poses.points[point].cameras[i]);
      Eigen::Vector2d& p = poses.sightings[point][i];
      p = scales[camera] * p.array() + corners[camera];
    }
  }
}

// Colours of the points as their first cameras see them.
std::vector<std::array<uint8_t, 3>> point_colours(const FolderFrames& frames, const Poses& poses, const Job& job) {
  std::vector<std::array<uint8_t, 3>> colours(poses.points.size(), {128, 128, 128});
  for (size_t camera = 0; camera < poses.cameras.size(); ++camera) {
    job.check();
    const RgbImage image = frames.load(poses.frame_of_camera[camera]);
    for (size_t i = 0; i < poses.points.size(); ++i) {
      if (poses.points[i].cameras.empty() || poses.points[i].cameras.front() != static_cast<int>(camera)) continue;
      const Eigen::Vector2d& p = poses.sightings[i].front();
      const Rgb& pixel = image.at(std::clamp(static_cast<int>(p.x()), 0, image.width - 1),
                                  std::clamp(static_cast<int>(p.y()), 0, image.height - 1));
      colours[i] = {pixel.r, pixel.g, pixel.b};
    }
  }
  return colours;
}

void write_colmap(const std::filesystem::path& folder, const Poses& poses,
                  const std::vector<std::array<uint8_t, 3>>& colours) {
  const ColmapText text = colmap_text({poses.cameras, poses.points, poses.sightings, colours});
  OutputFolder out(folder, OutputFolder::Existing::merge);
  out.fill([&] {
    write_file(out.path() / "cameras.txt", text.cameras);
    write_file(out.path() / "images.txt", text.images);
    write_file(out.path() / "points3D.txt", text.points);
  });
  out.keep();
}

void print_files(const PosesCommand& command) {
  if (!command.output.empty()) std::printf("%s: the cameras\n", printable(command.output).c_str());
  if (!command.colmap.empty()) std::printf("%s: cameras and points for COLMAP\n", printable(command.colmap).c_str());
}

void print_table(const PosesReport& report) {
  int posed = 0;
  for (const FrameReport& frame : report.frames) {
    if (!frame.posed) continue;
    ++posed;
    std::printf("%s: %d features, %d matches, %d inliers, %.2f px\n", printable(frame.name).c_str(), frame.features,
                frame.matches, frame.inliers, frame.reprojection_px);
  }
  print_left_out(report);
  std::printf("%d of %zu photos, %d points, %.2f px\n", posed, report.frames.size(), report.points,
              report.reprojection_px);
  if (report.motion == Motion::rotation) std::printf("no parallax was found: the camera only turned\n");
  if (!report.doubt.empty())
    std::fprintf(stderr, "ldp poses: these poses may be wrong: %s\n", printable(with_switches(report.doubt)).c_str());
}

int run(const PosesCommand& command, const Session& session) {
  if (!command.output.empty()) {
    check_output_file(command.output, OutputKind::cameras);
    std::error_code error;
    if (std::filesystem::equivalent(command.output, command.setup.cameras, error))
      throw BadInput(command.output + ": is also read, as --cameras: choose another name");
  }
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  const PreparedBuild prepared = prepare(command.setup, job);
  Poses poses = prepared.options.cameras.empty()
                    ? estimate_poses(prepared.frames, prepared.options.poses, job)
                    : triangulate(prepared.frames, prepared.options.cameras, prepared.options.poses, job);
  job.check();
  std::vector<std::array<uint8_t, 3>> colours;
  if (!command.colmap.empty()) colours = point_colours(prepared.frames, poses, job);
  to_stored_size(prepared.frames, poses);
  if (!command.colmap.empty()) write_colmap(command.colmap, poses, colours);
  if (!command.output.empty()) write_text(command.output, transforms_json(poses.cameras));
  bar.reset();
  for (const std::string& what : {sideways(poses.cameras), wrong_lens(poses)})
    if (!what.empty()) std::fprintf(stderr, "ldp poses: %s\n", printable(with_switches(what)).c_str());
  if (session.json) {
    std::printf("%s\n", json_text(poses_json(poses.report), 1).c_str());
  } else {
    print_table(poses.report);
    print_files(command);
  }
  return kDone;
}

}  // namespace

void add_poses(Program& program) {
  auto command = std::make_shared<PosesCommand>();
  CLI::App& app = add_command(program, "poses", "Estimate the cameras of photos",
                              [command](const Session& session) { return run(*command, session); });
  add_capture_options(app, command->setup);
  app.add_option("-o,--output", command->output, "The transforms.json to write");
  app.add_option("--colmap", command->colmap, "The folder to write a COLMAP text model to");
}

}  // namespace ldp
