#include "core/estimate/small_frames.h"

#include <algorithm>
#include <cmath>

#include "core/photos/resize.h"

namespace ldp {

SmallFrames::SmallFrames(const FrameSource& source, int64_t most_pixels, const Job& job) : source_(source) {
  frames_.resize(static_cast<size_t>(source.size()));
  for (int i = 0; i < source.size(); ++i) {
    job.check();
    RgbImage frame = source.load(i);
    if (i == 0) {
      full_width_ = frame.width, full_height_ = frame.height;
      scale_ = std::max(1.0, std::sqrt(1.0 * frame.width * frame.height / static_cast<double>(most_pixels)));
    }
    const auto smaller = [&](int side) { return std::max(1, static_cast<int>(std::lround(side / scale_))); };
    frames_[static_cast<size_t>(i)] =
        scale_ > 1 ? resize_by_area(frame, smaller(frame.width), smaller(frame.height)) : std::move(frame);
  }
}

std::vector<Camera> fitted(std::vector<Camera> cameras, const SmallFrames& frames) {
  const RgbImage first = frames.load(0);
  for (Camera& camera : cameras) {
    Intrinsics& k = camera.intrinsics;
    const double x = 1.0 * first.width / k.width, y = 1.0 * first.height / k.height;
    k.fx *= x, k.cx *= x, k.fy *= y, k.cy *= y;
    k.width = first.width, k.height = first.height;
  }
  return cameras;
}

}  // namespace ldp
