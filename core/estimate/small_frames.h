// The frames of a source scaled down and kept in memory: together they take a few megabytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/photos/frame_source.h"
#include "core/poses/poses.h"

namespace ldp {

class SmallFrames final : public FrameSource {
 public:
  // Each frame of the size that frame `like` has becomes one of at most so many pixels; others are scaled as much.
  // Loads every frame once, that one twice.
  SmallFrames(const FrameSource& source, int like, int64_t most_pixels, const Job& job);

  int size() const override { return static_cast<int>(frames_.size()); }
  std::string name(int index) const override { return source_.name(index); }
  RgbImage load(int index) const override { return frames_.at(static_cast<size_t>(index)); }
  std::optional<double> focal_hint(int index) const override { return source_.focal_hint(index); }

  double scale() const { return scale_; }  // from this one's pixels to those of the source; at least 1
  int full_width() const { return full_width_; }
  int full_height() const { return full_height_; }
  int small_width() const { return small_width_; }
  int small_height() const { return small_height_; }

 private:
  const FrameSource& source_;
  std::vector<RgbImage> frames_;
  double scale_ = 1;
  int full_width_ = 0, full_height_ = 0, small_width_ = 0, small_height_ = 0;
};

// Poses of the source's frames that are of that size, for these: the same in the world, in pixels of these.
Poses fitted(Poses poses, const SmallFrames& frames);

}  // namespace ldp
