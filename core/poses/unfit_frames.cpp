#include "core/poses/unfit_frames.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/poses/poses_tuning.h"

namespace ldp::sfm {
namespace {

// A camera that stood still, or a photo stored twice: a step of no length.
bool repeats(const Frame& before, const Frame& frame) {
  return frame.features.size() > 0 && frame.picture.grey.samples == before.picture.grey.samples;
}

class DenseFrames {
 public:
  DenseFrames(const std::vector<Frame>& frames, FramePairs& pairs, const Job& job)
      : frames_(frames), pairs_(pairs), job_(job) {}

  // Of frames that move by less than the step from the first of them, one after the other, the sharpest stays.
  void leave_out(double step, std::vector<LeftOut>& unfit) const {
    std::vector<int> alike;
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (unfit[i]) continue;
      const int frame = static_cast<int>(i);
      if (!alike.empty() && motion(alike.front(), frame) >= step) keep_sharpest(std::exchange(alike, {}), unfit);
      alike.push_back(frame);
    }
    keep_sharpest(alike, unfit);
  }

 private:
  double motion(int a, int b) const {
    job_.check();
    return pairs_.motion(frames_, a, b);
  }

  void keep_sharpest(const std::vector<int>& alike, std::vector<LeftOut>& unfit) const {
    if (alike.size() < 2) return;
    const int kept = *std::max_element(alike.begin(), alike.end(), [&](int one, int other) {
      return frames_[static_cast<size_t>(one)].sharpness < frames_[static_cast<size_t>(other)].sharpness;
    });
    for (const int frame : alike) {
      if (frame == kept) continue;
      unfit[static_cast<size_t>(frame)].cause = LeftOutCause::needless;
      unfit[static_cast<size_t>(frame)].original = frames_[static_cast<size_t>(kept)].name;
    }
  }

  const std::vector<Frame>& frames_;
  FramePairs& pairs_;
  const Job& job_;
};

size_t fit_count(const std::vector<LeftOut>& unfit) {
  return static_cast<size_t>(std::count_if(unfit.begin(), unfit.end(), [](const LeftOut& why) { return !why; }));
}

// More than kManyFrames are thinned by the first of the steps that leaves no more than these, or else by the last that
// leaves enough.
std::vector<LeftOut> without_needless(const std::vector<Frame>& frames, FramePairs& pairs, const Job& job,
                                      const std::vector<LeftOut>& unfit) {
  std::vector<LeftOut> fewer = unfit;
  for (const double step : kDenseSteps) {
    if (fit_count(fewer) <= kManyFrames) break;
    std::vector<LeftOut> fewest = unfit;
    DenseFrames(frames, pairs, job).leave_out(step, fewest);
    if (fit_count(fewest) < size_t{kMinPosedFrames}) break;
    fewer = std::move(fewest);
  }
  return fewer;
}

}  // namespace

std::pair<int, int> common_size(const std::vector<Frame>& frames) {
  std::map<std::pair<int, int>, int> counts;
  for (const Frame& frame : frames) ++counts[{frame.features.width, frame.features.height}];
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

std::vector<LeftOut> unfit_frames(const std::vector<Frame>& frames, FramePairs& pairs, const Job& job) {
  if (frames.empty()) return {};
  const std::pair<int, int> size = common_size(frames);
  std::vector<LeftOut> unfit(frames.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    const Features& f = frames[i].features;
    if (std::pair(f.width, f.height) != size) {
      unfit[i].cause = LeftOutCause::other_size;
    } else if (i > 0 && repeats(frames[i - 1], frames[i])) {
      unfit[i].cause = LeftOutCause::repeated;
      unfit[i].original = frames[i - 1].name;
    }
  }
  return without_needless(frames, pairs, job, unfit);
}

void require_three_fit(const std::vector<Frame>& frames, const std::vector<LeftOut>& unfit) {
  if (fit_count(unfit) >= size_t{kMinPosedFrames}) return;
  const auto first =
      std::find_if(unfit.begin(), unfit.end(), [](const LeftOut& why) { return static_cast<bool>(why); });
  throw Impossible("only " + std::to_string(fit_count(unfit)) + " of " + std::to_string(frames.size()) +
                   " photos can be used; at least 3 are needed, all of one size and none the same as the one before; " +
                   frames[static_cast<size_t>(first - unfit.begin())].name + ": " + words_of(*first));
}

}  // namespace ldp::sfm
