#include "core/poses/coverage.h"

#include <algorithm>

#include "core/poses/poses_tuning.h"

namespace ldp::sfm {
namespace {

// Cells of all photos, and in which of them something lies.
class OccupiedCells {
 public:
  explicit OccupiedCells(const MatchedSweep& sweep)
      : sweep_(sweep), occupied_(static_cast<size_t>(sweep.frames()) * kCoverageGrid * kCoverageGrid, false) {}

  void add(int frame, const Eigen::Vector2d& from_middle_px) {
    const Features& photo = sweep_.features[static_cast<size_t>(frame)];
    occupied_[static_cast<size_t>(frame) * kCoverageGrid * kCoverageGrid +
              grid_cell(from_middle_px, photo, kCoverageGrid)] = true;
  }
  int count() const { return static_cast<int>(std::count(occupied_.begin(), occupied_.end(), true)); }

 private:
  const MatchedSweep& sweep_;
  std::vector<bool> occupied_;
};

}  // namespace

Coverage coverage(const MatchedSweep& sweep, const Reconstruction& r) {
  OccupiedCells explained(sweep), matched(sweep);
  for (const Track& track : r.tracks) {
    for (const Observation& o : track) explained.add(o.frame, o.position_px);
  }
  const auto add_match = [&](int frame, int feature) {
    if (!r.left_out[static_cast<size_t>(frame)])
      matched.add(frame, sweep.features[static_cast<size_t>(frame)].centred(feature));
  };
  for (const PairMatches& pair : sweep.pairs) {
    for (const Match& match : pair.matches) add_match(pair.a, match.a), add_match(pair.b, match.b);
  }
  return {explained.count(), matched.count()};
}

}  // namespace ldp::sfm
