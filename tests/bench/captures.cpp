#include "captures.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "arc.h"
#include "images.h"
#include "poses.h"
#include "rectify.h"
#include "transforms.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

class Frames final : public FrameSource {
 public:
  Frames(fs::path folder, const std::vector<Camera>& cameras) : folder_(std::move(folder)) {
    for (const Camera& camera : cameras) names_.push_back(camera.name);
  }
  int size() const override { return static_cast<int>(names_.size()); }
  std::string name(int index) const override { return names_[static_cast<size_t>(index)]; }
  RgbImage load(int index) const override { return read_image(folder_ / name(index)); }
  std::optional<double> focal_hint(int) const override { return {}; }

 private:
  fs::path folder_;
  std::vector<std::string> names_;
};

}  // namespace

PreparedCapture prepare_capture(const std::string& folder) {
  const fs::path capture(folder);
  const auto given = read_transforms(capture / "transforms.json");
  const Frames frames(fs::exists(capture / "frames") ? capture / "frames" : capture, given);
  const Poses poses = triangulate(frames, given, {}, {});
  const ArcFit fit = fit_arc(poses.cameras, {});
  return {lay_grid(fit.arc, poses.cameras, poses.points, {}),
          rectify(frames, poses.cameras, poses.frame_of_camera, poses.points, fit.arc, {})};
}

}  // namespace ldp
