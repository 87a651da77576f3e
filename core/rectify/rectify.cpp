#include "rectify.h"

#include <algorithm>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>

#include "exposure.h"
#include "flatten.h"
#include "resample.h"

namespace ldp {
namespace {

constexpr int kStrip = 32;                                      // columns resampled between two looks at the job
constexpr size_t kBytesPerPixel = 10, kBytesAtOnce = 32 << 20;  // of photos being worked on
constexpr std::array<double, 3> kLuma = {0.299, 0.587, 0.114};

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

using GainTable = std::array<uint16_t, 256>;

GainTable gain_table(float gain, double weight) {
  GainTable table{};
  for (int value = 0; value < 256; ++value) {
    const double scaled = value * static_cast<double>(gain) * weight * kSampleScale;
    table[static_cast<size_t>(value)] = static_cast<uint16_t>(std::min(scaled + 0.5, weight * 255 * kSampleScale));
  }
  return table;
}

Plane<uint16_t> weighted_grey(const RgbImage& photo, const Gain& gain) {
  const GainTable r = gain_table(gain[0], kLuma[0]), g = gain_table(gain[1], kLuma[1]),
                  b = gain_table(gain[2], kLuma[2]);
  Plane<uint16_t> grey(photo.width, photo.height);
  for (size_t i = 0; i < photo.samples.size(); ++i) {
    const Rgb p = photo.samples[i];
    grey.samples[i] = static_cast<uint16_t>(r[p.r] + g[p.g] + b[p.b]);
  }
  return grey;
}

Plane<uint16_t> red_minus_green(const RgbImage& photo, const Gain& gain) {
  const GainTable r = gain_table(gain[0], 1), g = gain_table(gain[1], 1);
  Plane<uint16_t> tint(photo.width, photo.height);
  for (size_t i = 0; i < photo.samples.size(); ++i) {
    const Rgb p = photo.samples[i];
    tint.samples[i] = static_cast<uint16_t>(std::clamp(128 * kSampleScale + r[p.r] - g[p.g], 0, 255 * kSampleScale));
  }
  return tint;
}

Plane<uint16_t> channel(const RgbImage& photo, uint8_t Rgb::*member, float gain) {
  const GainTable table = gain_table(gain, 1);
  Plane<uint16_t> plane(photo.width, photo.height);
  for (size_t i = 0; i < photo.samples.size(); ++i) plane.samples[i] = table[photo.samples[i].*member];
  return plane;
}

struct Planes {
  Plane<uint16_t> grey, tint;
};

Planes make_planes(const RgbImage& photo, const Gain& gain, const Job& job) {
  return {flatten(weighted_grey(photo, gain), job), flatten(red_minus_green(photo, gain), job)};
}

// Resamples one column and finds its longest run of rows inside the photo.
void fill_column(const Planes& planes, const ColumnMap& map, int column, UprightFrame& frame) {
  int begin = 0, best_begin = 0, best_end = 0;
  for (int y = 0; y < frame.camera.height; ++y) {
    const SourcePosition position = map.at(y);
    frame.columns.at(y, column) = interpolate(planes.grey, position);
    frame.tint.at(y, column) = interpolate(planes.tint, position);
    if (!position.inside) begin = y + 1;
    if (y + 1 - begin > best_end - best_begin) {
      best_begin = begin;
      best_end = y + 1;
    }
  }
  frame.valid_begin[static_cast<size_t>(column)] = static_cast<int16_t>(best_begin);
  frame.valid_end[static_cast<size_t>(column)] = static_cast<int16_t>(best_end);
}

UprightFrame make_upright(const Planes& planes, const Camera& camera, const UprightCamera& upright, const Gain& gain,
                          const Job& job) {
  UprightFrame frame;
  frame.camera = upright;
  frame.gain = gain;
  frame.columns = frame.tint = GreyImage(upright.height, upright.width);
  frame.valid_begin.resize(static_cast<size_t>(upright.width));
  frame.valid_end.resize(static_cast<size_t>(upright.width));
  parallel_for(job, (upright.width + kStrip - 1) / kStrip, [&](int strip) {
    const int end = std::min(upright.width, (strip + 1) * kStrip);
    for (int x = strip * kStrip; x < end; ++x) fill_column(planes, ColumnMap(camera, upright, x), x, frame);
  });
  return frame;
}

// Photos that are worked on at a time: one a thread where memory allows.
int photos_at_once(const std::vector<Camera>& cameras, const Job& job) {
  size_t largest = 1;
  for (const Camera& camera : cameras)
    largest = std::max(largest, static_cast<size_t>(camera.intrinsics.width) *
                                    static_cast<size_t>(std::max(1, camera.intrinsics.height)));
  return std::clamp(static_cast<int>(kBytesAtOnce / (kBytesPerPixel * largest)), 1, std::max(1, job.threads));
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

std::vector<UprightFrame> rectify(const FrameSource& frames, const std::vector<Camera>& cameras,
                                  const std::vector<int>& frame_of_camera, const std::vector<ScenePoint>& points,
                                  const Arc& arc, const Job& job) {
  if (cameras.size() != frame_of_camera.size()) throw std::logic_error("rectify: one frame index per camera is needed");
  const int at_once = photos_at_once(cameras, job);
  Job photos = job, inside = job;  // threads over photos, and inside one photo
  photos.threads = at_once;
  inside.threads = std::max(1, job.threads / at_once);
  const auto load = [&](size_t k) { return load_checked(frames, frame_of_camera[k], cameras[k]); };
  std::vector<Thumbnail> thumbnails(cameras.size());
  for_each_photo(photos, "exposure", cameras.size(), [&](size_t k) { thumbnails[k] = make_thumbnail(load(k)); });
  const auto gains = exposure_gains(cameras, thumbnails, points);
  std::vector<UprightFrame> upright(cameras.size());
  for_each_photo(photos, "rectify", cameras.size(), [&](size_t k) {
    const Planes planes = make_planes(load(k), gains[k], inside);
    upright[k] =
        make_upright(planes, cameras[k], upright_camera(cameras[k], arc.axis(), frame_of_camera[k]), gains[k], inside);
  });
  return upright;
}

RgbImage upright_colour(const FrameSource& frames, const Camera& camera, const UprightFrame& frame) {
  const UprightCamera& upright = frame.camera;
  const RgbImage photo = load_checked(frames, upright.source, camera);
  RgbImage colour(upright.width, upright.height);
  constexpr std::array<uint8_t Rgb::*, 3> kChannels = {&Rgb::r, &Rgb::g, &Rgb::b};
  for (size_t c = 0; c < 3; ++c) {
    const Plane<uint16_t> plane = channel(photo, kChannels[c], frame.gain[c]);
    for (int x = 0; x < upright.width; ++x) {
      const ColumnMap map(camera, upright, x);
      for (int y = 0; y < upright.height; ++y) colour.at(x, y).*kChannels[c] = interpolate(plane, map.at(y));
    }
  }
  return colour;
}

}  // namespace ldp
