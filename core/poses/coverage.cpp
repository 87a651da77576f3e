#include "core/poses/coverage.h"

#include <algorithm>

#include "core/poses/poses_tuning.h"

namespace ldp::sfm {
namespace {

// The parts of all photos of which something was noted.
class Parts {
 public:
  explicit Parts(const MatchedSweep& sweep)
      : sweep_(sweep), noted_(static_cast<size_t>(sweep.frames()) * kCoverageGrid * kCoverageGrid, false) {}

  void note(int frame, const Eigen::Vector2d& from_middle_px) {
    const Features& photo = sweep_.features[static_cast<size_t>(frame)];
    noted_[static_cast<size_t>(frame) * kCoverageGrid * kCoverageGrid +
           grid_cell(from_middle_px, photo, kCoverageGrid)] = true;
  }
  int count() const { return static_cast<int>(std::count(noted_.begin(), noted_.end(), true)); }

 private:
  const MatchedSweep& sweep_;
  std::vector<bool> noted_;
};

}  // namespace

Coverage coverage(const MatchedSweep& sweep, const Reconstruction& r) {
  Parts explained(sweep), matched(sweep);
  for (const Track& track : r.tracks) {
    for (const Observation& o : track) explained.note(o.frame, o.position_px);
  }
  const auto note_match = [&](int frame, int feature) {
    if (!r.left_out[static_cast<size_t>(frame)])
      matched.note(frame, sweep.features[static_cast<size_t>(frame)].centred(feature));
  };
  for (const PairMatches& pair : sweep.pairs) {
    for (const Match& match : pair.matches) note_match(pair.a, match.a), note_match(pair.b, match.b);
  }
  return {explained.count(), matched.count()};
}

}  // namespace ldp::sfm
