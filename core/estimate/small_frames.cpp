#include "core/estimate/small_frames.h"

#include <algorithm>
#include <cmath>

#include "core/photos/resize.h"

namespace ldp {

SmallFrames::SmallFrames(const FrameSource& source, int like, int64_t most_pixels, const Job& job) : source_(source) {
  const RgbImage whole = source.load(like);
  full_width_ = whole.width, full_height_ = whole.height;
  scale_ = std::max(1.0, std::sqrt(1.0 * whole.width * whole.height / static_cast<double>(most_pixels)));
  const auto smaller = [&](int side) { return std::max(1, static_cast<int>(std::lround(side / scale_))); };
  small_width_ = smaller(full_width_), small_height_ = smaller(full_height_);
  frames_.resize(static_cast<size_t>(source.size()));
  for (int i = 0; i < source.size(); ++i) {
    job.check();
    RgbImage frame = source.load(i);
    frames_[static_cast<size_t>(i)] =
        scale_ > 1 ? resize_by_area(frame, smaller(frame.width), smaller(frame.height)) : std::move(frame);
  }
}

Poses fitted(Poses poses, const SmallFrames& frames) {
  const Eigen::Vector2d scale(1.0 * frames.small_width() / frames.full_width(),
                              1.0 * frames.small_height() / frames.full_height());
  for (Camera& camera : poses.cameras) {
    Intrinsics& k = camera.intrinsics;
    k.fx *= scale.x(), k.cx *= scale.x(), k.fy *= scale.y(), k.cy *= scale.y();
    k.width = frames.small_width(), k.height = frames.small_height();
  }
  for (std::vector<Eigen::Vector2d>& point : poses.sightings)
    for (Eigen::Vector2d& sighting : point) sighting = sighting.cwiseProduct(scale);
  poses.report.reprojection_px *= scale.x();
  return poses;
}

}  // namespace ldp
