// Photographs that are measured when they are first read.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/photos/frame_source.h"
#include "core/verdict/photo_measures.h"

namespace ldp {

class MeasuredFrames : public FrameSource {
 public:
  // Refers to it.
  explicit MeasuredFrames(const FrameSource& frames) : frames_(frames), measures_(static_cast<size_t>(frames.size())) {}

  int size() const override { return frames_.size(); }
  std::string name(int index) const override { return frames_.name(index); }
  std::optional<double> focal_hint(int index) const override { return frames_.focal_hint(index); }

  // Several threads may read different ones, not the same one at once.
  RgbImage load(int index) const override {
    RgbImage photo = frames_.load(index);
    auto& measures = measures_[static_cast<size_t>(index)];
    if (!measures) measures = measure(photo);
    return photo;
  }

  // Of one that was read; throws std::bad_optional_access of another.
  const PhotoMeasures& of(int index) const { return measures_.at(static_cast<size_t>(index)).value(); }

 private:
  const FrameSource& frames_;
  mutable std::vector<std::optional<PhotoMeasures>> measures_;
};

}  // namespace ldp
