#include "core/poses/frame_pairs.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace ldp::sfm {
namespace {

size_t pairs_of(size_t frames) { return frames < 2 ? 0 : frames * (frames - 1) / 2; }

double median_way(const std::vector<Match>& matches, const Features& a, const Features& b) {
  if (matches.empty()) return std::numeric_limits<double>::infinity();
  std::vector<double> ways;
  for (const Match& match : matches)
    ways.push_back((a.positions[static_cast<size_t>(match.a)] - b.positions[static_cast<size_t>(match.b)]).norm());
  const auto middle = ways.begin() + static_cast<std::ptrdiff_t>(ways.size() / 2);
  std::nth_element(ways.begin(), middle, ways.end());
  return *middle / std::max(a.width, a.height);
}

size_t index_of(int a, int b) { return pairs_of(static_cast<size_t>(b)) + static_cast<size_t>(a); }

}  // namespace

void FramePairs::make_room(size_t frames) {
  for (int b = pairs_.empty() ? 1 : pairs_.back().b + 1; b < static_cast<int>(frames); ++b) {
    for (int a = 0; a < b; ++a) pairs_.push_back({a, b, {}});
  }
  matched_.resize(pairs_.size(), Matched::no);
  motion_.resize(pairs_.size(), -1);
}

void FramePairs::match(const std::vector<Frame>& frames, size_t index, Matched kind) {
  PairMatches& pair = pairs_[index];
  const Features &a = frames[static_cast<size_t>(pair.a)].features, &b = frames[static_cast<size_t>(pair.b)].features;
  pair.matches = match_and_verify(a, b, kind == Matched::as_neighbours, options_);
  matched_[index] = kind;
}

void FramePairs::match_all(const std::vector<Frame>& frames, const std::vector<LeftOut>& unfit, const Job& job) {
  make_room(frames.size());
  std::vector<int> place(frames.size(), 0);  // among those that are fit
  for (size_t i = 1; i < frames.size(); ++i) place[i] = place[i - 1] + (unfit[i - 1] ? 0 : 1);
  std::vector<std::pair<size_t, Matched>> missing;
  for (size_t i = 0; i < pairs_.size(); ++i) {
    const auto a = static_cast<size_t>(pairs_[i].a), b = static_cast<size_t>(pairs_[i].b);
    const Matched wanted = kind(place[b] - place[a]);
    if (!unfit[a] && !unfit[b] && matched_[i] != wanted) missing.emplace_back(i, wanted);
  }
  parallel_for(job, static_cast<int>(missing.size()), [&](int i) {
    const auto& [index, wanted] = missing[static_cast<size_t>(i)];
    match(frames, index, wanted);
  });
}

double FramePairs::motion(const std::vector<Frame>& frames, int a, int b) {
  make_room(frames.size());
  const size_t index = index_of(a, b);
  if (motion_[index] >= 0) return motion_[index];
  if (matched_[index] != Matched::as_neighbours) match(frames, index, Matched::as_neighbours);
  return motion_[index] = median_way(pairs_[index].matches, frames[static_cast<size_t>(a)].features,
                                     frames[static_cast<size_t>(b)].features);
}

}  // namespace ldp::sfm
