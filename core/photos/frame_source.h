// Where photographs come from. Frames are decoded when asked for, so that a build holds one at a time and its memory
// does not grow with their number.
#pragma once

#include <optional>
#include <string>

#include "core/base/plane.h"

namespace ldp {

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual int size() const = 0;
  virtual std::string name(int index) const = 0;  // file name without folders; unique in the source
  virtual RgbImage load(int index) const = 0;  // upright as stored in EXIF; throws std::runtime_error naming the file
  virtual std::optional<double> focal_hint(int index) const = 0;  // focal length / longer image side, from EXIF
};

}  // namespace ldp
