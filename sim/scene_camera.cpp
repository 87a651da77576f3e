#include <algorithm>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "core/geometry/degrees.h"
#include "sim/devices.h"
#include "sim/playback_camera.h"
#include "sim/scene/scenes.h"
#include "sim/scene_capture.h"

namespace ldp {
namespace {

SceneCaptureOptions options_from(const Url& url) {
  url.allow_only(std::string(PlaybackCamera::kOptions) + " frames arc width height noise seed");
  SceneCaptureOptions options;
  options.scene = url.path();
  const auto& names = scene_names();
  if (std::find(names.begin(), names.end(), options.scene) == names.end()) {
    std::string known;
    for (const std::string& name : names) known += " " + name;
    throw std::runtime_error("'" + url.text() + "': no scene of that name; known:" + known);
  }
  options.path.frames = url.integer("frames", options.path.frames, {1, 1000});
  options.path.arc_rad = url.number("arc", 180, {0, 360}) * kRadiansPerDegree;
  options.path.width = url.integer("width", options.path.width, {16, 4096});
  options.path.height = url.integer("height", options.path.height, {16, 4096});
  options.noise = url.number("noise", 0, {0, 50});
  options.seed = static_cast<uint32_t>(url.integer("seed", 1, {0, 1e9}));
  options.path.seed = options.seed;
  return options;
}

class RenderedSweep {
 public:
  explicit RenderedSweep(const SceneCaptureOptions& options) : sweep_(options), count_(options.path.frames) {
    job_.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }
  bool render(const std::function<bool()>& give_up) {
    while (static_cast<int>(images_.size()) < count_) {
      if (give_up()) return false;
      const int frame = static_cast<int>(images_.size());
      images_.push_back(std::make_shared<const RgbImage>(sweep_.take(frame, job_).colour));
    }
    return true;
  }
  CameraFrame frame(int64_t index) const {
    const auto& image = images_[static_cast<size_t>(index)];
    CameraFrame frame;
    frame.format = PixelFormat::rgb24;
    frame.width = image->width;
    frame.height = image->height;
    frame.planes = {{&image->samples.data()->r, image->samples.size() * sizeof(Rgb), image->width * 3}};
    frame.lease = image;
    return frame;
  }

 private:
  SceneSweep sweep_;
  int count_;
  Job job_;
  std::vector<std::shared_ptr<const RgbImage>> images_;
};

}  // namespace

void check_scene_camera(const Url& url) {
  options_from(url);
  PlaybackCamera::timing_from(url);
}

std::unique_ptr<CameraDevice> open_scene_camera(const Url& url) {
  check_scene_camera(url);
  const SceneCaptureOptions options = options_from(url);
  Playback playback;
  playback.name = url.text();
  playback.format = PixelFormat::rgb24;
  playback.width = options.path.width;
  playback.height = options.path.height;
  playback.count = options.path.frames;
  const auto rendered = std::make_shared<RenderedSweep>(options);
  playback.prepare = [rendered](const std::function<bool()>& give_up) { return rendered->render(give_up); };
  playback.frame = [rendered](int64_t index) { return rendered->frame(index); };
  return std::make_unique<PlaybackCamera>(PlaybackCamera::timing_from(url), std::move(playback));
}

}  // namespace ldp
