#include "sim/scene_capture.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/base/files.h"
#include "core/captures/json_text.h"
#include "core/captures/transforms.h"
#include "core/photos/images.h"
#include "sim/npy.h"
#include "sim/scene/crowd.h"
#include "sim/scene/random.h"
#include "sim/scene/scenes.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kFrameInterval_ns = 350'000'000;
constexpr double kExposure_s = 0.004;

void write_views(const fs::path& folder, const std::string& name, const Picture& picture, const std::string& file) {
  write_file(folder / name / file, encode_png(picture.colour));
  write_file(folder / (name + "_depth") / fs::path(file).replace_extension(".npy"), encode_npy_half(picture.depth));
}

void write_cameras(const fs::path& file, const std::string& folder, std::vector<Camera> cameras) {
  for (Camera& camera : cameras) camera.name = folder + "/" + camera.name;
  write_transforms(file, cameras);
}

// No clock is read: the same options give the same bytes.
std::string capture_json(const SceneCaptureOptions& options, const SceneSweep& sweep,
                         const std::vector<double>& exposures) {
  nlohmann::ordered_json json;
  json["version"] = 1;
  json["device"] = "simulated";
  json["camera"] = "scene:" + options.scene + "?seed=" + std::to_string(options.seed);
  json["width"] = options.path.width;
  json["height"] = options.path.height;
  json["arm_length"] = options.path.radius;
  json["exposure_locked"] = options.exposure_drift == 0 && !options.meters;
  json["begin_utc"] = "2026-01-01T12:00:00Z";
  json["begin_ns"] = 0;
  json["end_ns"] = kFrameInterval_ns * options.path.frames;
  json["complete"] = true;
  json["frames"] = nlohmann::ordered_json::array();
  for (int i = 0; i < options.path.frames; ++i) {
    json["frames"].push_back({{"file", "frames/" + sweep.cameras()[static_cast<size_t>(i)].name},
                              {"time_ns", kFrameInterval_ns * i},
                              {"exposure_s", kExposure_s * exposures[static_cast<size_t>(i)]},
                              {"gain", 1.0}});
  }
  return json_text(json, 1) + "\n";
}

SceneDescription scene_in_shade(const SceneCaptureOptions& options) {
  SceneDescription description = make_scene(options.scene, options.seed);
  description.shade = static_cast<float>(options.shade);
  return description;
}

}  // namespace

SceneSweep::SceneSweep(const SceneCaptureOptions& options)
    : options_(options), cameras_(sweep_cameras(options.path)), at_rest_(scene_in_shade(options)) {}

// One slow swing about 1: brighter, then darker, as when a sweep passes the sun.
double SceneSweep::exposure(int frame) const {
  const double phase = 2 * std::numbers::pi * frame / std::max(1, options_.path.frames);
  return 1 + options_.exposure_drift * std::sin(phase + 0.5);
}

Picture SceneSweep::take(int frame, const Job& job) const {
  Random random(mix_bits(options_.seed + 1000U) + static_cast<uint64_t>(frame));
  PictureOptions picture;
  picture.exposure = exposure(frame);
  picture.meters = options_.meters;
  picture.noise = options_.noise;
  picture.noise_seed = random.bits();
  picture.motion_blur_px = options_.blur_px * random.uniform();
  const Camera& camera = cameras_.at(static_cast<size_t>(frame));
  if (options_.moving_share <= 0 && options_.crowd <= 0) return take_picture(at_rest_, camera, picture, job);
  SceneDescription moment = moved(at_rest_.description(), options_.moving_share, frame, options_.seed);
  moment = with_crowd(std::move(moment), options_.path, options_.crowd, frame, options_.seed);
  return take_picture(Scene(std::move(moment)), camera, picture, job);
}

namespace {

void write_around(const SceneCaptureOptions& options, const Scene& at_rest, const fs::path& folder, const Job& job) {
  PictureOptions picture;
  picture.meters = options.meters;
  const Surround seen = take_surround(at_rest, options.path, options.around, picture, job);
  fs::create_directory(folder);
  write_file(folder / "panorama.png", encode_png(seen.one_eye));
  write_file(folder / "stereo.png", encode_png(seen.two_eyes));
  write_file(folder / "distance.npy", encode_npy_half(seen.distance));
}

}  // namespace

void write_scene_capture(const SceneCaptureOptions& options, const fs::path& folder, const Job& job) {
  const SceneSweep sweep(options);
  const std::vector<Camera> novel = options.novel_views ? novel_cameras(options.path) : std::vector<Camera>{};
  for (const char* name : {"frames", "frames_depth"}) fs::create_directory(folder / name);
  std::vector<double> exposures;
  const double total = options.path.frames + static_cast<double>(novel.size());
  for (int i = 0; i < options.path.frames; ++i) {
    job.report("rendering", i / total);
    const Picture taken = sweep.take(i, job);
    exposures.push_back(taken.exposure);
    write_views(folder, "frames", taken, sweep.cameras()[static_cast<size_t>(i)].name);
  }
  write_cameras(folder / "transforms.json", "frames", sweep.cameras());
  if (!novel.empty()) {
    for (const char* name : {"novel", "novel_depth"}) fs::create_directory(folder / name);
    PictureOptions novel_options;
    novel_options.meters = options.meters;
    for (size_t i = 0; i < novel.size(); ++i) {
      job.report("rendering", (options.path.frames + static_cast<double>(i)) / total);
      write_views(folder, "novel", take_picture(sweep.at_rest(), novel[i], novel_options, job), novel[i].name);
    }
    write_cameras(folder / "novel.json", "novel", novel);
  }
  if (options.around.width > 0) write_around(options, sweep.at_rest(), folder / "around", job);
  write_file(folder / "capture.json", capture_json(options, sweep, exposures));
  job.report("rendering", 1);
}

}  // namespace ldp
