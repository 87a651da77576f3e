#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include "sim/devices.h"
#include "sim/playback_camera.h"
#include "sim/scene/scenes.h"
#include "sim/scene_capture.h"

namespace ldp {
namespace {

constexpr double kRadians = 0.017453292519943295;

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
  options.path.arc_rad = url.number("arc", 180, {0, 360}) * kRadians;
  options.path.width = url.integer("width", options.path.width, {16, 4096});
  options.path.height = url.integer("height", options.path.height, {16, 4096});
  options.noise = url.number("noise", 0, {0, 50});
  options.seed = static_cast<uint32_t>(url.integer("seed", 1, {0, 1e9}));
  options.path.seed = options.seed;
  return options;
}

std::vector<std::shared_ptr<const RgbImage>> render(const SceneCaptureOptions& options) {
  const SceneSweep sweep(options);
  Job job;
  job.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::vector<std::shared_ptr<const RgbImage>> images;
  for (int frame = 0; frame < options.path.frames; ++frame) {
    images.push_back(std::make_shared<const RgbImage>(sweep.take(frame, job).colour));
  }
  return images;
}

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
  playback.frame = [images = render(options)](int64_t index) {
    CameraFrame frame;
    const auto& image = images[static_cast<size_t>(index)];
    frame.format = PixelFormat::rgb24;
    frame.width = image->width;
    frame.height = image->height;
    frame.planes = {{&image->samples.data()->r, image->samples.size() * sizeof(Rgb), image->width * 3}};
    frame.lease = image;
    return frame;
  };
  return std::make_unique<PlaybackCamera>(PlaybackCamera::timing_from(url), std::move(playback));
}

}  // namespace ldp
