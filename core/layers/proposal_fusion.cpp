#include "core/layers/proposal_fusion.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <memory>

#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

using namespace tuning;

enum Change : uint8_t { kSame, kNearer, kFarther };

constexpr size_t kCamerasAtOnce = 4;
constexpr int kStripColumns = 128;

// Calls use(begin, end) for strips of columns, for some at the same time.
void for_each_strip(int columns, const Job& job, const std::function<void(int, int)>& use) {
  parallel_for(job, (columns + kStripColumns - 1) / kStripColumns,
               [&](int strip) { use(strip * kStripColumns, std::min(columns, (strip + 1) * kStripColumns)); });
}

// Of cameras from `first` to before `end`.
std::vector<size_t> with_witnesses(const PhotoConsistency& photos, size_t first, size_t end) {
  std::vector<size_t> all;
  for (size_t k = first; k < end; ++k) {
    all.push_back(k);
    for (const size_t witness : photos.witnesses(k)) all.push_back(witness);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// A depth map as the cameras' columns that are compared see it, farther surfaces going on where none covers: painted
// for some of them at a time, each map let go when no one asks for it.
class Hypothesis {
 public:
  // All but the map must outlive it.
  Hypothesis(const PanoramaGrid& grid, const DisparityMap& map, const std::vector<UprightFrame>& frames,
             int columns_apart, PaintedViews& memory);
  ~Hypothesis();
  Hypothesis(const Hypothesis&) = delete;
  Hypothesis& operator=(const Hypothesis&) = delete;

  void look(size_t camera);
  void forget(size_t camera);

  // Null where not looked at.
  const std::vector<const VisibilityMap*>& maps() const { return maps_; }
  const SeenPixels& seen(size_t camera) const { return views_[camera]->seen; }

 private:
  Brush brush_;
  const std::vector<UprightFrame>& frames_;
  int columns_apart_;
  PaintedViews& memory_;
  std::vector<std::unique_ptr<PaintedView>> views_;  // one per camera
  std::vector<const VisibilityMap*> maps_;
};

Hypothesis::Hypothesis(const PanoramaGrid& grid, const DisparityMap& map, const std::vector<UprightFrame>& frames,
                       int columns_apart, PaintedViews& memory)
    : brush_(grid, map, {}),
      frames_(frames),
      columns_apart_(columns_apart),
      memory_(memory),
      views_(frames.size()),
      maps_(frames.size()) {}

Hypothesis::~Hypothesis() {
  for (size_t camera = 0; camera < views_.size(); ++camera) forget(camera);
}

void Hypothesis::look(size_t camera) {
  const UprightCamera& from = frames_[camera].camera;
  auto view = memory_.take();
  empty_map(brush_.grid, from, {}, view->map, columns_apart_);
  assign(view->seen, from.height, columns_of_map(from, columns_apart_), kSeesNothing);
  MapPainter painter(brush_, from, view->map, &view->seen, columns_apart_);
  for (int x = 0; x < brush_.grid.width; ++x) painter.paint(x);
  continue_farther_surfaces(view->map);
  maps_[camera] = &view->map;
  views_[camera] = std::move(view);
}

void Hypothesis::forget(size_t camera) {
  maps_[camera] = nullptr;
  if (views_[camera]) memory_.give_back(std::move(views_[camera]));
}

// Calls use(camera) for every camera once, in no order and at the same time for some, when all hypotheses have looked
// through it and its witnesses.
void for_each_camera(const PhotoConsistency& photos, size_t cameras, const std::vector<Hypothesis*>& hypotheses,
                     const Job& job, const std::function<void(size_t)>& use) {
  std::vector<size_t> kept;
  const int count = static_cast<int>(hypotheses.size());
  for (size_t first = 0; first < cameras; first += kCamerasAtOnce) {
    const size_t end = std::min(cameras, first + kCamerasAtOnce);
    std::vector<size_t> wanted = with_witnesses(photos, first, end), missing;
    for (const size_t camera : kept)
      if (!std::binary_search(wanted.begin(), wanted.end(), camera))
        for (Hypothesis* hypothesis : hypotheses) hypothesis->forget(camera);
    std::set_difference(wanted.begin(), wanted.end(), kept.begin(), kept.end(), std::back_inserter(missing));
    parallel_for(job, count * static_cast<int>(missing.size()), [&](int i) {
      hypotheses[static_cast<size_t>(i % count)]->look(missing[static_cast<size_t>(i / count)]);
    });
    parallel_for(job, static_cast<int>(end - first), [&](int i) { use(first + static_cast<size_t>(i)); });
    kept = std::move(wanted);
  }
}

// By how much the others contradict what a camera sees of a map, and a little more where the map itself shows nothing:
// that the farther surface goes on there is a guess.
int contradiction(int differs, uint32_t seen) {
  const bool guessed = seen == kSeesNothing && differs != kUnknownDifference;
  return guessed ? differs + kUncoveredDifference : differs;
}

// Sums over pixels, of which cameras add to one at the same time. (Integers: their order does not matter.)
class PixelSums {
 public:
  PixelSums(int columns, int rows) : sums_(rows, columns, 0) {}

  void add(uint32_t pixel, int value) {
    std::atomic_ref<int32_t>(sums_.samples[pixel]).fetch_add(value, std::memory_order_relaxed);
  }
  Plane<int32_t> take() { return std::move(sums_); }

 private:
  Plane<int32_t> sums_;
};

// How far apart the disparities of neighbours are, summed over a pixel's four; what is farther apart than `most` is
// just another surface.
class Smoothness {
 public:
  Smoothness(const PanoramaGrid& grid, const Plane<uint8_t>& changes, const DisparityMap& layer,
             const DisparityMap& proposal, int most)
      : grid_(grid), changes_(changes), layer_(layer), proposal_(proposal), most_(most) {}

  // By how much smoother the layer gets at (x, y), which has four neighbours, if the pixel takes the proposal over, and
  // its neighbours do that change likewise.
  int gain(int x, int y) const {
    const uint8_t kind = changes_.at(y, x);
    int sum = 0;
    for (const auto& [right, down] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const int beside = neighbour_column(grid_, x + right);
      const bool moves = changes_.at(y + down, beside) == kind;
      const int before = layer_.at(beside, y + down), after = (moves ? proposal_ : layer_).at(beside, y + down);
      if (before == kNoDisparity) continue;
      sum += apart(layer_.at(x, y), before) - apart(proposal_.at(x, y), after);
    }
    return sum;
  }

 private:
  int apart(int a, int b) const { return std::min(std::abs(a - b), most_); }

  const PanoramaGrid& grid_;
  const Plane<uint8_t>& changes_;
  const DisparityMap &layer_, &proposal_;
  int most_;
};

// Adds what smoothness is worth to the gains. A proposal that is rougher has to be wanted the more by the photographs.
// That it is smoother counts only where they tell something of it, and where it goes farther: near surfaces would grow
// into what one photo alone sees beside them.
void add_smoothness(const PanoramaGrid& grid, const Plane<uint8_t>& changes, const DisparityMap& layer,
                    const DisparityMap& proposal, int roughness, const Job& job, Plane<int32_t>& gains) {
  const int most = std::max(1, static_cast<int>(parallax_steps(grid, kRoughApartPx)));
  const Smoothness smoothness(grid, changes, layer, proposal, most);
  const int edge = grid.wraps ? 0 : 1;
  for_each_strip(layer.width, job, [&](int begin, int end) {
    for (int x = std::max(begin, edge); x < std::min(end, layer.width - edge); ++x)
      for (int y = 1; y + 1 < layer.height; ++y) {
        const uint8_t kind = changes.at(y, x);
        if (kind == kSame) continue;
        int32_t& gain = gains.at(y, x);
        int smoother = smoothness.gain(x, y);
        if (kind == kNearer || gain == 0) smoother = std::min(smoother, 0);
        gain += roughness * smoother / most;
      }
  });
}

// Sums of gains over squares, of one kind of change: of one column after the other, from `first` on.
class SquareSums {
 public:
  SquareSums(const PanoramaGrid& grid, const Plane<int32_t>& gains, const Plane<uint8_t>& changes, Change kind,
             int reach_px, int enough, int first)
      : grid_(grid),
        gains_(gains),
        changes_(changes),
        kind_(kind),
        reach_px_(reach_px),
        across_px_(grid.wraps ? std::min(reach_px, (grid.width - 1) / 2) : reach_px),
        enough_(enough),
        first_(first),
        next_(first - across_px_),
        rows_(static_cast<size_t>(gains.width), 0) {}

  // Calls use(y) for the pixels (x, y) of that kind around which the sum tells enough.
  template <class Use>
  void next(int x, Use use) {
    for (; next_ <= x + across_px_; ++next_) add(next_, 1);
    if (x > first_) add(x - across_px_ - 1, -1);
    int64_t sum = 0;
    for (int y = 0; y < std::min(reach_px_, gains_.width); ++y) sum += rows_[static_cast<size_t>(y)];
    for (int y = 0; y < gains_.width; ++y) {
      if (y + reach_px_ < gains_.width) sum += rows_[static_cast<size_t>(y + reach_px_)];
      if (y > reach_px_) sum -= rows_[static_cast<size_t>(y - reach_px_ - 1)];
      if (sum > enough_ && changes_.at(y, x) == kind_) use(y);
    }
  }

 private:
  void add(int beside, int times) {
    const int x = neighbour_column(grid_, beside);
    if (x < 0) return;
    for (int y = 0; y < gains_.width; ++y)
      if (changes_.at(y, x) == kind_) rows_[static_cast<size_t>(y)] += int64_t{times} * gains_.at(y, x);
  }

  const PanoramaGrid& grid_;
  const Plane<int32_t>& gains_;
  const Plane<uint8_t>& changes_;
  Change kind_;
  int reach_px_, across_px_;  // up and down; to the sides, where all round counts once
  int enough_, first_;
  int next_;                   // columns below this have been added
  std::vector<int64_t> rows_;  // of the columns within reach
};

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

ProposalFusion::ProposalFusion(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, int columns_apart)
    : grid_(grid), frames_(frames), columns_apart_(columns_apart), photos_(grid, frames, columns_apart) {}

void ProposalFusion::fuse(const DisparityMap& proposal, int reach_px, const Job& job, DisparityMap& layer) {
  take_over(proposal, reach_px, tuning::kPreferred, job, layer);
}

void ProposalFusion::simplify(const DisparityMap& simpler, int reach_px, const Job& job, DisparityMap& layer) {
  take_over(simpler, reach_px, -tuning::kSimplerAllowed, job, layer);
}

void ProposalFusion::take_over(const DisparityMap& proposal, int reach_px, int least_gain, const Job& job,
                               DisparityMap& layer) {
  const Plane<uint8_t> change = changes(layer, proposal, job);
  Plane<int32_t> gain = gains(change, layer, proposal, job);
  add_smoothness(grid_, change, layer, proposal, tuning::kRoughness / columns_apart_, job, gain);
  for_each_strip(layer.width, job, [&](int begin, int end) {
    for (const Change kind : {kNearer, kFarther}) {
      SquareSums sums(grid_, gain, change, kind, reach_px, least_gain / columns_apart_, begin);
      for (int x = begin; x < end; ++x) sums.next(x, [&](int y) { layer.at(x, y) = proposal.at(x, y); });
    }
  });
}

// Stored column by column.
Plane<uint8_t> ProposalFusion::changes(const DisparityMap& layer, const DisparityMap& proposal, const Job& job) const {
  Plane<uint8_t> columns(layer.height, layer.width, kSame);
  const int tolerance = static_cast<int>(parallax_steps(grid_, tuning::kFusionApartPx));
  for_each_strip(layer.width, job, [&](int begin, int end) {
    for (int y = 0; y < layer.height; ++y)
      for (int x = begin; x < end; ++x) {
        const int own = layer.at(x, y), other = proposal.at(x, y);
        if (own == kNoDisparity || other == kNoDisparity || std::abs(own - other) <= tolerance) continue;
        columns.at(y, x) = other > own ? kNearer : kFarther;
      }
  });
  return columns;
}

// By how much less the photographs contradict the proposal than the layer, by pixel of the panorama that changes,
// stored like the changes [1/kDifferenceSteps grey levels]: over the cameras' pixels that show one under either.
Plane<int32_t> ProposalFusion::gains(const Plane<uint8_t>& changes, const DisparityMap& layer,
                                     const DisparityMap& proposal, const Job& job) {
  std::array<std::unique_ptr<Hypothesis>, 2> both;
  parallel_for(job, 2, [&](int i) {
    both[static_cast<size_t>(i)] =
        std::make_unique<Hypothesis>(grid_, i == 0 ? layer : proposal, frames_, columns_apart_, memory_);
  });
  Hypothesis &own = *both[0], &other = *both[1];
  PixelSums sums(layer.width, layer.height);
  const auto changed = [&](uint32_t pixel) { return pixel != kSeesNothing && changes.samples[pixel] != kSame; };
  for_each_camera(photos_, frames_.size(), {&own, &other}, job, [&](size_t camera) {
    const UprightFrame& frame = frames_[camera];
    PhotoConsistency::Pixels asked;
    std::vector<int> of_own, of_other;
    for (int compared = 0; compared < own.seen(camera).height; ++compared) {
      const uint32_t *before = own.seen(camera).row(compared), *after = other.seen(camera).row(compared);
      asked.x = compared * columns_apart_;
      const auto column = static_cast<size_t>(asked.x);
      asked.rows.clear();
      for (int y = frame.valid_begin[column]; y < frame.valid_end[column]; ++y)
        if (changed(before[y]) || changed(after[y])) asked.rows.push_back(y);
      photos_.look(camera, asked);
      photos_.differences(camera, asked, own.maps(), of_own);
      photos_.differences(camera, asked, other.maps(), of_other);
      for (size_t i = 0; i < asked.rows.size(); ++i) {
        const uint32_t hidden = before[asked.rows[i]], shown = after[asked.rows[i]];
        const int gain = contradiction(of_own[i], hidden) - contradiction(of_other[i], shown);
        if (changed(hidden)) sums.add(hidden, gain);
        if (changed(shown) && shown != hidden) sums.add(shown, gain);
      }
    }
  });
  return sums.take();
}

}  // namespace ldp
