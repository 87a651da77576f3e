// Why a photo takes no part in the sweep: told apart by an enum, said to people in one place.
#pragma once

#include <cstdint>
#include <string>

namespace ldp {

enum class LeftOutCause : uint8_t {
  none,               // it takes part
  other_size,         // than most photos
  repeated,           // the same picture as the one before, named `original`
  needless,           // of many photos one that shows next to nothing that `original` does not
  without_texture,    // next to no features
  unmatched,          // with no photo at all
  matched_elsewhere,  // with photos only that do not connect with the rest
  few_inliers,        // only `inliers` of its points agree with the cameras
  few_shared_points,  // too few for resection
  up_or_down,         // it looks along the arc's axis
  no_camera           // none of its name and size was given
};

struct LeftOut {
  LeftOutCause cause = LeftOutCause::none;
  std::string original = {};
  int inliers = 0;

  explicit operator bool() const { return cause != LeftOutCause::none; }
  // What it shows is seen all the same.
  bool is_shown_by_another() const { return cause == LeftOutCause::repeated || cause == LeftOutCause::needless; }
};

// A sentence without its photo's name and full stop; empty where it takes part.
std::string words_of(const LeftOut& why);

}  // namespace ldp
