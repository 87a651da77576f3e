// The frames of a sweep as poses know them, and what matches between each two of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/photos/left_out.h"
#include "core/poses/features/features.h"
#include "core/poses/tracks/geometric_verification.h"
#include "core/poses/tracks/tracks.h"

namespace ldp::sfm {

struct Frame {
  std::string name;
  std::optional<double> focal_hint;  // focal length / longer side, from EXIF
  GreyPhoto picture;
  double sharpness = 0;  // mean square of the differences of neighbouring pixels of `picture`
  Features features;
};

// A pair is matched when it is first asked for, as neighbours in the sweep or as frames far apart (TwoViewOptions).
class FramePairs {
 public:
  explicit FramePairs(const TwoViewOptions& options) : options_(options) {}

  // Those of all frames that can be part of the sweep, as which they are counted.
  void match_all(const std::vector<Frame>& frames, const std::vector<LeftOut>& unfit, const Job& job);
  // How far frame b > a has moved from a: the median way of what matches, as of neighbours, in longer sides of the
  // picture; infinite where nothing does.
  double motion(const std::vector<Frame>& frames, int a, int b);

  // Of all frames that any pair was asked for, by their later frame; without matches where they were not.
  const std::vector<PairMatches>& all() const { return pairs_; }

 private:
  void make_room(size_t frames);
  enum class Matched : uint8_t { no, as_neighbours, as_far_apart };
  Matched kind(int apart) const {
    return apart <= options_.sequential_window ? Matched::as_neighbours : Matched::as_far_apart;
  }
  void match(const std::vector<Frame>& frames, size_t index, Matched kind);

  TwoViewOptions options_;
  std::vector<PairMatches> pairs_;
  std::vector<Matched> matched_;  // by pair
  std::vector<double> motion_;    // the same; below 0: not known yet
};

}  // namespace ldp::sfm
