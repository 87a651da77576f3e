#include "tests/bench/captures.h"

#include <filesystem>
#include <utility>

#include "core/arc/arc.h"
#include "core/captures/transforms.h"
#include "core/photos/images.h"
#include "core/poses/poses.h"
#include "core/rectify/rectify.h"

namespace ldp {
CaptureFrames::CaptureFrames(std::filesystem::path folder, const std::vector<Camera>& cameras)
    : folder_(std::move(folder)) {
  for (const Camera& camera : cameras) names_.push_back(camera.name);
}

RgbImage CaptureFrames::load(int index) const { return read_image(folder_ / name(index)); }

PreparedCapture prepare_capture(const std::string& folder) {
  const std::filesystem::path capture(folder);
  const auto given = read_transforms(capture / "transforms.json");
  const CaptureFrames frames(std::filesystem::exists(capture / "frames") ? capture / "frames" : capture, given);
  const Poses poses = triangulate(frames, given, {}, {});
  const ArcFit fit = fit_arc(poses.cameras);
  return {lay_grid(fit.arc, poses.cameras, poses.points, {}),
          rectify(frames, poses.cameras, poses.frame_of_camera, poses.points, fit.arc, 1, {})};
}

}  // namespace ldp
