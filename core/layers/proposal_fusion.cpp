// Which of two depth maps the photographs contradict less, place by place. (Fusion of proposals, Lempitsky et al. 2010,
// chosen by what every camera sees under both instead of by an energy of rays: only so does a surface pay for what it
// hides.)
#include <algorithm>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <vector>

#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/map_painter.h"
#include "core/layers/photo_consistency.h"

namespace ldp::layers {
namespace {

using namespace tuning;

constexpr int kCamerasAtOnce = 4;
constexpr uint16_t kNoPart = 0xFFFF;

// What is decided at once: in each cell of the panorama the pixels at which the proposal is nearer than the layer, and
// those at which it is farther.
class Parts {
 public:
  Parts(const PanoramaGrid& grid, int cell_px, const DisparityMap& layer, const DisparityMap& proposal)
      : columns(layer.height, layer.width, kNoPart) {
    while (cells(layer.width, cell_px) * cells(layer.height, cell_px) > kNoPart / 2) ++cell_px;
    const int across = cells(layer.width, cell_px);
    count = 2 * static_cast<size_t>(across * cells(layer.height, cell_px));
    const int tolerance = static_cast<int>(parallax_steps(grid, kFusionApartPx));
    for (int y = 0; y < layer.height; ++y)
      for (int x = 0; x < layer.width; ++x) {
        const int own = layer.at(x, y), other = proposal.at(x, y);
        if (own == kNoDisparity || other == kNoDisparity || std::abs(own - other) <= tolerance) continue;
        const int cell = y / cell_px * across + x / cell_px;
        columns.at(y, x) = static_cast<uint16_t>(2 * cell + (other > own ? 1 : 0));
      }
  }

  size_t count = 0;
  Plane<uint16_t> columns;  // column by column; kNoPart where both are one surface

 private:
  static int cells(int pixels, int cell_px) { return (pixels + cell_px - 1) / cell_px; }
};

// One of the two depth maps, as some of the cameras see it.
class Hypothesis {
 public:
  Hypothesis(const PanoramaGrid& grid, const DisparityMap& layer, const Parts& parts, size_t cameras)
      : brush_(grid, layer), parts_(parts), maps_(cameras), seen_(cameras) {}

  void look(size_t camera, const UprightCamera& from) {
    maps_[camera] = empty_map(brush_.grid, from, {});
    seen_[camera] = Plane<uint16_t>(from.height, from.width, kNoPart);
    const Names names{parts_.columns, seen_[camera]};
    MapPainter painter(brush_, from, {}, maps_[camera], &names);
    for (int x = 0; x < brush_.grid.width; ++x) painter.paint(x);
  }
  void forget(size_t camera) {
    maps_[camera] = {};
    seen_[camera] = {};
  }

  const std::vector<VisibilityMap>& maps() const { return maps_; }
  const Plane<uint16_t>& parts_seen(size_t camera) const { return seen_[camera]; }

 private:
  Brush brush_;
  const Parts& parts_;
  std::vector<VisibilityMap> maps_;
  std::vector<Plane<uint16_t>> seen_;  // of each camera's pixels, stored as the maps are
};

// By how much less the photographs contradict the proposal than the layer, by part. A few cameras at a time, so that
// only they and their witnesses are kept.
class Comparison {
 public:
  Comparison(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const Parts& parts,
             const DisparityMap& layer, const DisparityMap& proposal)
      : frames_(frames),
        parts_(parts),
        photos_(grid, frames),
        own_(grid, layer, parts, frames.size()),
        other_(grid, proposal, parts, frames.size()) {}

  std::vector<int64_t> gains(const Job& job) {
    std::vector<int64_t> sums(parts_.count, 0);
    std::vector<size_t> kept;
    for (size_t first = 0; first < frames_.size(); first += kCamerasAtOnce) {
      std::vector<size_t> cameras;
      for (size_t k = first; k < std::min(frames_.size(), first + kCamerasAtOnce); ++k) cameras.push_back(k);
      look(with_witnesses(cameras), kept, job);
      std::vector<std::vector<int64_t>> of_camera(cameras.size());
      parallel_for(job, static_cast<int>(cameras.size()),
                   [&](int i) { of_camera[static_cast<size_t>(i)] = gains_in(cameras[static_cast<size_t>(i)]); });
      for (const std::vector<int64_t>& gains : of_camera)
        std::transform(sums.begin(), sums.end(), gains.begin(), sums.begin(), std::plus<>());
    }
    return sums;
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

  // Over the camera's pixels that show a part under either.
  std::vector<int64_t> gains_in(size_t camera) const {
    std::vector<int64_t> gains(parts_.count, 0);
    const UprightFrame& frame = frames_[camera];
    for (int x = 0; x < frame.camera.width; ++x) {
      const uint16_t *before = own_.parts_seen(camera).row(x), *after = other_.parts_seen(camera).row(x);
      for (int y = frame.valid_begin[static_cast<size_t>(x)]; y < frame.valid_end[static_cast<size_t>(x)]; ++y) {
        if (before[y] == kNoPart && after[y] == kNoPart) continue;
        const int gain =
            photos_.difference(camera, x, y, own_.maps()) - photos_.difference(camera, x, y, other_.maps());
        if (before[y] != kNoPart) gains[before[y]] += gain;
        if (after[y] != kNoPart && after[y] != before[y]) gains[after[y]] += gain;
      }
    }
    return gains;
  }

  const std::vector<UprightFrame>& frames_;
  const Parts& parts_;
  PhotoConsistency photos_;
  Hypothesis own_, other_;
};

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

void fuse_proposal(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const DisparityMap& proposal,
                   int cell_px, const Job& job, DisparityMap& layer) {
  const Parts parts(grid, cell_px, layer, proposal);
  const std::vector<int64_t> gains = Comparison(grid, frames, parts, layer, proposal).gains(job);
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x)
      if (const uint16_t part = parts.columns.at(y, x); part != kNoPart && gains[part] > 0)
        layer.at(x, y) = proposal.at(x, y);
}

}  // namespace ldp
