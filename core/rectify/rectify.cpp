#include "core/rectify/rectify.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "core/photos/exposure/calibration.h"
#include "core/photos/exposure/local_exposure.h"
#include "core/photos/exposure/photo_exposure.h"
#include "core/photos/exposure_compensation.h"
#include "core/rectify/background_subtraction.h"
#include "core/rectify/rectify_tuning.h"
#include "core/rectify/resample.h"

namespace ldp::rectification {
namespace {

constexpr std::array<int, 3> kLuma = {299, 587, 114};  // ITU-R BT.601
constexpr int kLumaSum = 1000;

RgbImage load_checked(const FrameSource& frames, int index, const Camera& camera) {
  RgbImage photo = frames.load(index);
  if (photo.width != camera.intrinsics.width || photo.height != camera.intrinsics.height) {
    throw std::runtime_error("photo '" + camera.name + "' has " + std::to_string(photo.width) + "x" +
                             std::to_string(photo.height) + " pixels, its camera " +
                             std::to_string(camera.intrinsics.width) + "x" + std::to_string(camera.intrinsics.height) +
                             ": all photos of a capture need the size given for them");
  }
  return photo;
}

// Of red, green and blue, in kSampleScale levels.
struct Sample {
  int r = 0, g = 0, b = 0;

  Sample(Rgb p, const PhotoExposure& exposure, int x, int y) {
    const auto scaled = [](int level) { return level * kSampleScale; };
    const auto even = exposure({scaled(p.r), scaled(p.g), scaled(p.b)}, kSampleScale, x, y);
    r = std::min(even[0], kHighest), g = std::min(even[1], kHighest), b = std::min(even[2], kHighest);
  }

 private:
  static constexpr int kHighest = 255 * kSampleScale;
};

// At which exposure each photograph is sampled.
class Exposures {
 public:
  Exposures(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails,
            const std::vector<ScenePoint>& points)
      : cameras_(cameras), gains_(exposure_gains(cameras, thumbnails, points)) {
    if (!LocalExposure(cameras, gains_).is_wanted()) return;
    calibration_ = calibrate(exposure::overlaps(cameras, thumbnails, points), cameras.size());
    local_.emplace(cameras, calibration_->light_gains);
  }

  PhotoExposure of_photo(size_t k) const {
    const Intrinsics& lens = cameras_[k].intrinsics;
    if (!local_) return PhotoExposure(gains_[k]);
    return {{local_->over_photo(k), calibration_->response}, lens.width, lens.height};
  }

  const Gain& gain(size_t k) const { return gains_[k]; }
  const std::optional<Calibration>& calibration() const { return calibration_; }

 private:
  const std::vector<Camera>& cameras_;
  std::vector<Gain> gains_;
  std::optional<Calibration> calibration_;
  std::optional<LocalExposure> local_;
};

struct Planes {
  Plane<uint16_t> grey, tint;
};

// Grey, and red minus green.
Planes weighted(const RgbImage& photo, const PhotoExposure& exposure) {
  Planes planes{Plane<uint16_t>(photo.width, photo.height), Plane<uint16_t>(photo.width, photo.height)};
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) {
      const Sample s(photo.at(x, y), exposure, x, y);
      planes.grey.at(x, y) =
          static_cast<uint16_t>((kLuma[0] * s.r + kLuma[1] * s.g + kLuma[2] * s.b + kLumaSum / 2) / kLumaSum);
      planes.tint.at(x, y) = static_cast<uint16_t>(std::clamp(128 * kSampleScale + s.r - s.g, 0, 255 * kSampleScale));
    }
  return planes;
}

Planes make_planes(const RgbImage& photo, const PhotoExposure& exposure, const Job& job) {
  Planes planes = weighted(photo, exposure);
  planes.grey = flatten(planes.grey, job);
  planes.tint = flatten(planes.tint, job);
  return planes;
}

// The samples of an upright frame. Where its pixels are larger than the photograph's, several places spread over each
// are averaged.
class Resampler {
 public:
  Resampler(const Planes& planes, const Camera& camera, double pitch_px, UprightFrame& frame)
      : planes_(planes),
        camera_(camera),
        taps_(std::clamp(static_cast<int>(std::lround(pitch_px)), 1, kMostTaps)),
        frame_(frame) {}

  // Fills one column and finds its longest run of rows inside the photo.
  void fill(int column) const {
    std::vector<ColumnMap> maps;
    for (int i = 0; i < taps_; ++i) maps.emplace_back(camera_, frame_.camera, column + from_middle(i));
    int begin = 0, best_begin = 0, best_end = 0;
    for (int y = 0; y < frame_.camera.height; ++y) {
      if (!fill(maps, y, column)) begin = y + 1;
      if (y + 1 - begin > best_end - best_begin) {
        best_begin = begin;
        best_end = y + 1;
      }
    }
    frame_.valid_begin[static_cast<size_t>(column)] = static_cast<int16_t>(best_begin);
    frame_.valid_end[static_cast<size_t>(column)] = static_cast<int16_t>(best_end);
  }

 private:
  double from_middle(int tap) const { return (tap + 0.5) / taps_ - 0.5; }

  // One sample; is all of it inside the photo?
  bool fill(const std::vector<ColumnMap>& maps, int y, int column) const {
    int grey = 0, tint = 0;
    bool inside = true;
    for (const ColumnMap& map : maps)
      for (int j = 0; j < taps_; ++j) {
        const SourcePosition position = map.at(y + from_middle(j));
        const Interpolation interpolate(position);
        grey += interpolate(planes_.grey);
        tint += interpolate(planes_.tint);
        inside &= position.inside;
      }
    const int places = taps_ * taps_;
    frame_.columns.at(y, column) = static_cast<uint8_t>((grey + places / 2) / places);
    frame_.tint.at(y, column) = static_cast<uint8_t>((tint + places / 2) / places);
    return inside;
  }

  const Planes& planes_;
  const Camera& camera_;
  int taps_;
  UprightFrame& frame_;
};

UprightFrame make_upright(const Planes& planes, const Camera& camera, const UprightCamera& upright, double pitch_px,
                          const Job& job) {
  UprightFrame frame;
  frame.camera = upright;
  frame.columns = frame.tint = GreyImage(upright.height, upright.width);
  frame.valid_begin.resize(static_cast<size_t>(upright.width));
  frame.valid_end.resize(static_cast<size_t>(upright.width));
  const Resampler resampler(planes, camera, pitch_px, frame);
  parallel_for(job, (upright.width + kStrip - 1) / kStrip, [&](int strip) {
    const int end = std::min(upright.width, (strip + 1) * kStrip);
    for (int x = strip * kStrip; x < end; ++x) resampler.fill(x);
  });
  return frame;
}

// In pixels.
size_t largest_photo(const std::vector<Camera>& cameras) {
  size_t largest = 1;
  for (const Camera& camera : cameras)
    largest = std::max(largest, static_cast<size_t>(camera.intrinsics.width) *
                                    static_cast<size_t>(std::max(1, camera.intrinsics.height)));
  return largest;
}

// Photos that are worked on at a time: one a thread where memory allows.
int photos_at_once(const std::vector<Camera>& cameras, const Job& job) {
  return std::clamp(static_cast<int>(kBytesAtOnce / (kBytesPerPixel * largest_photo(cameras))), 1,
                    std::max(1, job.threads));
}

// body(i) for every photo, as many at a time as photos.threads, with progress.
void for_each_photo(const Job& photos, std::string_view stage, size_t count, const std::function<void(size_t)>& body) {
  std::mutex mutex;
  size_t done = 0;
  photos.report(stage, 0);
  parallel_for(photos, static_cast<int>(count), [&](int i) {
    body(static_cast<size_t>(i));
    const std::lock_guard lock(mutex);
    photos.report(stage, static_cast<double>(++done) / static_cast<double>(count));
  });
}

}  // namespace
}  // namespace ldp::rectification

namespace ldp {

using namespace rectification;

bool looks_straight_up_or_down(const Camera& camera, const Arc& arc) { return is_along(camera, arc.axis()); }

size_t upright_pixels(const std::vector<Camera>& cameras, const Arc& arc, double pitch_px) {
  size_t pixels = 0;
  for (const Camera& camera : cameras) {
    const UprightCamera upright = upright_camera(camera, arc.axis(), 0, pitch_px);
    pixels += static_cast<size_t>(upright.width) * static_cast<size_t>(upright.height);
  }
  return pixels;
}

std::vector<UprightFrame> rectify(const FrameSource& frames, const std::vector<Camera>& cameras,
                                  const std::vector<int>& frame_of_camera, const std::vector<ScenePoint>& points,
                                  const Arc& arc, double pitch_px, const Job& job, std::optional<Calibration>* local) {
  if (cameras.size() != frame_of_camera.size()) throw std::logic_error("rectify: one frame index per camera is needed");
  const int at_once = photos_at_once(cameras, job);
  Job photos = job, inside = job;  // threads over photos, and inside one photo
  photos.threads = at_once;
  inside.threads = std::max(1, job.threads / at_once);
  const auto load = [&](size_t k) { return load_checked(frames, frame_of_camera[k], cameras[k]); };
  std::vector<Thumbnail> thumbnails(cameras.size());
  std::vector<RgbImage> kept(cameras.size());  // for the second look, if all find room
  const bool keep = cameras.size() * sizeof(Rgb) * largest_photo(cameras) <= kBytesAtOnce;
  for_each_photo(photos, "exposure", cameras.size(), [&](size_t k) {
    RgbImage photo = load(k);
    thumbnails[k] = make_thumbnail(photo);
    if (keep) kept[k] = std::move(photo);
  });
  const Exposures exposures(cameras, thumbnails, points);
  std::vector<UprightFrame> upright(cameras.size());
  for_each_photo(photos, "rectify", cameras.size(), [&](size_t k) {
    const Planes planes = make_planes(keep ? std::exchange(kept[k], {}) : load(k), exposures.of_photo(k), inside);
    const UprightCamera camera = upright_camera(cameras[k], arc.axis(), frame_of_camera[k], pitch_px);
    upright[k] = make_upright(planes, cameras[k], camera, pitch_px, inside);
    upright[k].gain = exposures.gain(k);
  });
  if (local != nullptr) *local = exposures.calibration();
  return upright;
}

}  // namespace ldp
