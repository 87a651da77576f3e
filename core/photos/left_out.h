// Why a photo takes no part in the sweep: told apart by an enum, said to people in one place.
#pragma once

#include <cstdint>
#include <string>

#include "core/photos/images.h"

namespace ldp {

enum class LeftOutCause : uint8_t {
  none,               // it takes part
  other_size,         // than most photos: `size` against `common_size`
  repeated,           // the same picture as the one before, named `original`
  without_texture,    // next to no features
  unmatched,          // with no photo at all
  matched_elsewhere,  // with photos only that do not connect with the rest
  few_inliers,        // only `inliers` of its points agree with the cameras
  few_shared_points,  // too few for resection
  no_camera           // none was given for it
};

struct LeftOut {
  LeftOutCause cause = LeftOutCause::none;
  ImageSize size = {}, common_size = {};
  std::string original = {};
  int inliers = 0;

  explicit operator bool() const { return cause != LeftOutCause::none; }
};

// A sentence without its photo's name and full stop; empty where it takes part.
std::string words_of(const LeftOut& why);

}  // namespace ldp
