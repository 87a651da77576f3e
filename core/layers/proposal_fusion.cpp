// Which of two depth maps the photographs contradict less, place by place. (Fusion of proposals, Lempitsky et al. 2010,
// chosen by what every camera sees under both instead of by an energy of rays: only so does a surface pay for what it
// hides.)
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iterator>
#include <vector>

#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/map_painter.h"
#include "core/layers/neighbours.h"
#include "core/layers/photo_consistency.h"

namespace ldp::layers {
namespace {

using namespace tuning;

constexpr size_t kCamerasAtOnce = 4;

enum Change : uint8_t { kSame, kNearer, kFarther };

// What the proposal would change, stored column by column.
Plane<uint8_t> changes(const PanoramaGrid& grid, const DisparityMap& layer, const DisparityMap& proposal) {
  Plane<uint8_t> columns(layer.height, layer.width, kSame);
  const int tolerance = static_cast<int>(parallax_steps(grid, kFusionApartPx));
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x) {
      const int own = layer.at(x, y), other = proposal.at(x, y);
      if (own == kNoDisparity || other == kNoDisparity || std::abs(own - other) <= tolerance) continue;
      columns.at(y, x) = other > own ? kNearer : kFarther;
    }
  return columns;
}

// One of the two depth maps, as some of the cameras see it.
class Hypothesis {
 public:
  Hypothesis(const PanoramaGrid& grid, const DisparityMap& layer, size_t cameras)
      : brush_(grid, layer, {}), maps_(cameras), seen_(cameras) {}

  void look(size_t camera, const UprightCamera& from) {
    maps_[camera] = empty_map(brush_.grid, from, {});
    seen_[camera] = SeenPixels(from.height, from.width, kSeesNothing);
    MapPainter painter(brush_, from, maps_[camera], &seen_[camera]);
    for (int x = 0; x < brush_.grid.width; ++x) painter.paint(x);
  }
  void forget(size_t camera) {
    maps_[camera] = {};
    seen_[camera] = {};
  }

  const std::vector<VisibilityMap>& maps() const { return maps_; }
  const SeenPixels& seen(size_t camera) const { return seen_[camera]; }

 private:
  Brush brush_;
  std::vector<VisibilityMap> maps_;
  std::vector<SeenPixels> seen_;
};

// By how much less the photographs contradict the proposal than the layer, by pixel of the panorama that changes. A few
// cameras at a time, so that only they and their witnesses are kept.
class Comparison {
 public:
  Comparison(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const Plane<uint8_t>& changes,
             const DisparityMap& layer, const DisparityMap& proposal)
      : frames_(frames),
        changes_(changes),
        photos_(grid, frames),
        own_(grid, layer, frames.size()),
        other_(grid, proposal, frames.size()),
        gains_(changes.width, changes.height, 0) {}

  // Stored like the changes [1/kDifferenceSteps grey levels].
  Plane<int32_t> gains(const Job& job) {
    std::vector<size_t> kept;
    for (size_t first = 0; first < frames_.size(); first += kCamerasAtOnce) {
      std::vector<size_t> cameras;
      for (size_t k = first; k < std::min(frames_.size(), first + kCamerasAtOnce); ++k) cameras.push_back(k);
      look(with_witnesses(cameras), kept, job);
      parallel_for(job, static_cast<int>(cameras.size()),
                   [&](int i) { add_gains_of(cameras[static_cast<size_t>(i)]); });
    }
    return std::move(gains_);
  }

 private:
  std::vector<size_t> with_witnesses(const std::vector<size_t>& cameras) const {
    std::vector<size_t> all = cameras;
    for (const size_t k : cameras)
      for (const size_t witness : photos_.witnesses(k)) all.push_back(witness);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

  // Through the cameras that are wanted, and no others any longer.
  void look(const std::vector<size_t>& wanted, std::vector<size_t>& kept, const Job& job) {
    for (const size_t camera : kept)
      if (!std::binary_search(wanted.begin(), wanted.end(), camera)) own_.forget(camera), other_.forget(camera);
    std::vector<size_t> missing;
    std::set_difference(wanted.begin(), wanted.end(), kept.begin(), kept.end(), std::back_inserter(missing));
    parallel_for(job, 2 * static_cast<int>(missing.size()), [&](int i) {
      const size_t camera = missing[static_cast<size_t>(i / 2)];
      (i % 2 == 0 ? own_ : other_).look(camera, frames_[camera].camera);
    });
    kept = wanted;
  }

  // Over the camera's pixels that show a change under either. (Integers: the order of cameras does not matter.)
  void add_gains_of(size_t camera) {
    const UprightFrame& frame = frames_[camera];
    for (int x = 0; x < frame.camera.width; ++x) {
      const uint32_t *before = own_.seen(camera).row(x), *after = other_.seen(camera).row(x);
      for (int y = frame.valid_begin[static_cast<size_t>(x)]; y < frame.valid_end[static_cast<size_t>(x)]; ++y) {
        const bool hides = changed(before[y]), shows = changed(after[y]);
        if (!hides && !shows) continue;
        const int gain =
            photos_.difference(camera, x, y, own_.maps()) - photos_.difference(camera, x, y, other_.maps());
        if (hides) add(before[y], gain);
        if (shows && after[y] != before[y]) add(after[y], gain);
      }
    }
  }

  bool changed(uint32_t pixel) const { return pixel != kSeesNothing && changes_.samples[pixel] != kSame; }
  void add(uint32_t pixel, int gain) {
    std::atomic_ref<int32_t>(gains_.samples[pixel]).fetch_add(gain, std::memory_order_relaxed);
  }

  const std::vector<UprightFrame>& frames_;
  const Plane<uint8_t>& changes_;
  PhotoConsistency photos_;
  Hypothesis own_, other_;
  Plane<int32_t> gains_;
};

// Sums of gains over squares, of one kind of change.
class SquareSums {
 public:
  SquareSums(const Plane<int32_t>& gains, const Plane<uint8_t>& changes, Change kind, int reach_px)
      : gains_(gains),
        changes_(changes),
        kind_(kind),
        reach_px_(reach_px),
        rows_(static_cast<size_t>(gains.width), 0) {}

  // Calls use(y) for the pixels (x, y) of that kind around which the sum tells enough. For one x after the other, from
  // 0.
  template <class Use>
  void next(int x, Use use) {
    for (; last_ < std::min(x + reach_px_ + 1, gains_.height); ++last_) add(last_, 1);
    if (x > reach_px_) add(x - reach_px_ - 1, -1);
    int64_t sum = 0;
    for (int y = 0; y < std::min(reach_px_, gains_.width); ++y) sum += rows_[static_cast<size_t>(y)];
    for (int y = 0; y < gains_.width; ++y) {
      if (y + reach_px_ < gains_.width) sum += rows_[static_cast<size_t>(y + reach_px_)];
      if (y > reach_px_) sum -= rows_[static_cast<size_t>(y - reach_px_ - 1)];
      if (sum > kPreferred && changes_.at(y, x) == kind_) use(y);
    }
  }

 private:
  void add(int x, int times) {
    for (int y = 0; y < gains_.width; ++y)
      if (changes_.at(y, x) == kind_) rows_[static_cast<size_t>(y)] += int64_t{times} * gains_.at(y, x);
  }

  const Plane<int32_t>& gains_;
  const Plane<uint8_t>& changes_;
  Change kind_;
  int reach_px_, last_ = 0;    // columns below this have been added
  std::vector<int64_t> rows_;  // of the columns within reach
};

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

void fuse_proposal(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const DisparityMap& proposal,
                   int reach_px, const Job& job, DisparityMap& layer) {
  const Plane<uint8_t> change = changes(grid, layer, proposal);
  const Plane<int32_t> gains = Comparison(grid, frames, change, layer, proposal).gains(job);
  for (const Change kind : {kNearer, kFarther}) {
    SquareSums sums(gains, change, kind, reach_px);
    for (int x = 0; x < layer.width; ++x) sums.next(x, [&](int y) { layer.at(x, y) = proposal.at(x, y); });
  }
}

}  // namespace ldp
