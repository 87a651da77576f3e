// The sweep's own volumes of captures with given cameras.
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "arc.h"
#include "images.h"
#include "poses.h"
#include "rectify.h"
#include "solve_volumes.h"
#include "sweep.h"
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

Volume whole(const CostSource& source) {
  Volume volume(source.width(), source.height(), source.labels(), source.wraps());
  volume.median.resize(volume.cost.size());
  for (int x = 0; x < source.width(); x += 128) {
    const Window window{x, 0, std::min(128, source.width() - x), source.height()};
    source.read(window, volume.cost.data() + volume.index(x, 0), volume.median.data() + volume.index(x, 0));
  }
  return volume;
}

}  // namespace

Problem capture_problem(const std::string& folder) {
  const fs::path capture(folder);
  const auto given = read_transforms(capture / "transforms.json");
  const Frames frames(fs::exists(capture / "frames") ? capture / "frames" : capture, given);
  const Poses poses = triangulate(frames, given, {}, {});
  const ArcFit fit = fit_arc(poses.cameras, {});
  const PanoramaGrid grid = lay_grid(fit.arc, poses.cameras, poses.points, {});
  const auto upright = rectify(frames, poses.cameras, poses.frame_of_camera, poses.points, fit.arc, {});
  return {capture.filename(), whole(Sweep(upright, grid, {}, {}, {})), {}, {}, 1};
}

void save_volume(const Volume& volume, const std::string& file) {
  std::ofstream out(file, std::ios::binary);
  out << volume.width() << ' ' << volume.height() << ' ' << volume.labels() << ' ' << volume.wraps() << '\n';
  out.write(reinterpret_cast<const char*>(volume.cost.data()), static_cast<std::streamsize>(volume.cost.size()));
  out.write(reinterpret_cast<const char*>(volume.median.data()), static_cast<std::streamsize>(volume.median.size()));
}

Problem saved_problem(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  int width = 0, height = 0, labels = 0;
  bool wraps = false;
  in >> width >> height >> labels >> wraps;
  in.get();
  if (!in) throw std::runtime_error(file + ": not a volume saved by this program");
  Volume volume(width, height, labels, wraps);
  volume.median.resize(volume.cost.size());
  in.read(reinterpret_cast<char*>(volume.cost.data()), static_cast<std::streamsize>(volume.cost.size()));
  in.read(reinterpret_cast<char*>(volume.median.data()), static_cast<std::streamsize>(volume.median.size()));
  return {fs::path(file).stem(), std::move(volume), {}, {}, 1};
}

}  // namespace ldp
