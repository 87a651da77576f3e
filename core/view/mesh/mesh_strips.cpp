#include "core/view/mesh/mesh_strips.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

// Neighbouring columns; in a panorama that wraps they may go on past its ends.
struct Section {
  int begin = 0, end = 0;
  int columns() const { return end - begin; }
};

int wrapped(int column, int width) { return (column % width + width) % width; }

Layer cut_out(const Layer& layer, const Section& section) {
  Layer part;
  const int height = layer.coverage.height, width = layer.coverage.width;
  const auto columns = [&](const auto& from, auto& to) {
    if (from.empty()) return;
    to = {section.columns(), height};
    for (int x = 0; x < section.columns();) {
      const int column = wrapped(section.begin + x, width), count = std::min(section.columns() - x, width - column);
      for (int y = 0; y < height; ++y) std::copy_n(from.row(y) + column, count, to.row(y) + x);
      x += count;
    }
  };
  columns(layer.coverage, part.coverage);
  columns(layer.alpha, part.alpha);
  columns(layer.colour, part.colour);
  columns(layer.depth.codes, part.depth.codes);
  part.depth.block_px = layer.depth.block_px == 0 ? 0 : 1;  // a section may begin anywhere
  if (part.depth.block_px == 0) {
    part.depth.ranges = layer.depth.ranges;
    return part;
  }
  part.depth.ranges = {section.columns(), height};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < section.columns(); ++x)
      part.depth.ranges.at(x, y) = layer.depth.range(wrapped(section.begin + x, width), y);
  return part;
}

// A panorama of its own, with the same rays, that does not wrap.
LayeredPanorama cut_out(const LayeredPanorama& panorama, const Section& section) {
  LayeredPanorama part;
  part.grid = panorama.grid;
  part.grid.wraps = false;
  part.grid.width = section.columns();
  part.grid.theta_left = panorama.grid.theta_left - section.begin * panorama.grid.theta_pitch;
  for (const Layer& layer : panorama.layers) part.layers.push_back(cut_out(layer, section));
  return part;
}

struct Disparities {
  int low = kDisparitySteps, high = 0;

  // Smoothing moves a depth by half a step between codes at most.
  void include(const BlockRange& range) {
    const int step = range.high - range.low;
    low = std::min(low, 15 * range.low - step), high = std::max(high, 15 * range.high + step);
  }
};

Disparities disparities_of(const LayeredPanorama& panorama, const Section& section) {
  Disparities all;
  for (const Layer& layer : panorama.layers) {
    const int block_px = layer.depth.block_px;
    if (block_px == 0) {
      all.include(layer.depth.ranges.samples[0]);
      continue;
    }
    for (int y = 0; y < layer.depth.ranges.height; ++y)
      for (int x = section.begin; x < section.end; ++x)
        all.include(layer.depth.ranges.at(wrapped(x, panorama.grid.width) / block_px, y));
  }
  return all;
}

}  // namespace

MeshStrips::MeshStrips(const LayeredPanorama& panorama, int tiles_across, BeyondFrames beyond)
    : panorama_(panorama),
      layers_(static_cast<int>(panorama.layers.size())),
      beyond_(panorama.cameras.empty() ? BeyondFrames::nothing : beyond) {
  const PanoramaGrid& grid = panorama.grid;
  check_layers(panorama);
  if (layers_ == 0) return;
  if (beyond_ == BeyondFrames::surfaces) rows_beyond_ = static_cast<int>(std::ceil(kMostOfRows * grid.height)) + 1;
  const int last = grid.wraps ? grid.width : grid.width - 1, columns = tiles_across * kTilePx;
  const int margin = beyond_ == BeyondFrames::surfaces ? std::max(kTilePx, kBridge) : kTilePx;
  for (int begin = 0; begin < last; begin += columns) {
    Strip& strip = strips_.emplace_back();
    strip.begin = begin, strip.end = std::min(begin + columns, last);
    strip.from = begin - margin, strip.to = strip.end + 1 + margin;
    if (!grid.wraps) strip.from = std::max(0, strip.from), strip.to = std::min(grid.width, strip.to);
    const Disparities held = disparities_of(panorama, {strip.from, strip.to});
    strip.w_min = std::max(0.0F, static_cast<float>(grid.inverse_depth(held.low)));
    strip.w_max = static_cast<float>(grid.inverse_depth(held.high));
  }
}

ViewFrustum MeshStrips::frustum(const Camera& camera) const {
  return ViewFrustum(panorama_.grid, -rows_beyond_, panorama_.grid.height + 2 * rows_beyond_, camera);
}

bool MeshStrips::sees(const ViewFrustum& frustum, const Window& window, const Strip& strip) const {
  MeshTile tile;
  tile.w_min = strip.w_min, tile.w_max = strip.w_max;
  for (tile.x0 = strip.begin; tile.x0 < strip.end; tile.x0 += kTilePx)
    for (tile.y0 = 0; tile.y0 < panorama_.grid.height + 2 * rows_beyond_; tile.y0 += kTilePx)
      if (frustum.sees(tile, window)) return true;
  return false;
}

Mesh MeshStrips::made(const Strip& strip, const Job& job) const {
  LayeredPanorama part = cut_out(panorama_, {strip.from, strip.to});
  if (beyond_ == BeyondFrames::surfaces) part.cameras = panorama_.cameras, part.limits = panorama_.limits;
  Mesh mesh = build_mesh(part, strip.begin - strip.from, strip.end - strip.from, job);
  for (MeshTile& tile : mesh.tiles) tile.x0 += strip.from, tile.y0 += mesh.first_row + rows_beyond_;
  return mesh;
}

void MeshStrips::make(const std::vector<size_t>& places, const Job& job) {
  std::vector<size_t> missing;
  std::copy_if(places.begin(), places.end(), std::back_inserter(missing),
               [&](size_t place) { return !strips_[place].is_made; });
  parallel_for(job, static_cast<int>(missing.size()), [&](int i) {
    Strip& strip = strips_[missing[static_cast<size_t>(i)]];
    const std::lock_guard lock(strip.making);
    if (strip.is_made) return;
    strip.mesh = made(strip, job);
    strip.is_made = true;
  });
}

std::vector<size_t> MeshStrips::make_seen(const ViewFrustum& frustum, const Window& window, const Job& job) {
  std::vector<size_t> seen;
  for (size_t i = 0; i < strips_.size(); ++i)
    if (sees(frustum, window, strips_[i])) seen.push_back(i);
  make(seen, job);
  return seen;
}

void MeshStrips::make_all(const Job& job) {
  std::vector<size_t> all(strips_.size());
  std::iota(all.begin(), all.end(), size_t{0});
  make(all, job);
}

bool MeshStrips::all_made() const {
  return std::all_of(strips_.begin(), strips_.end(), [](const Strip& strip) { return strip.is_made.load(); });
}

void MeshStrips::forget_unseen(const ViewFrustum& frustum, const Window& window) {
  for (Strip& strip : strips_) {
    if (!strip.is_made || sees(frustum, window, strip)) continue;
    strip.is_made = false;
    strip.mesh = {};
  }
}

std::vector<const MeshTile*> MeshStrips::tiles(const std::vector<size_t>& places, int layers) const {
  std::vector<const MeshTile*> tiles;
  for (const size_t place : places)
    for (const MeshTile& tile : strips_[place].mesh.tiles)
      if (layers >= layers_ || tile.layer < layers) tiles.push_back(&tile);
  std::stable_sort(tiles.begin(), tiles.end(), [](const auto* a, const auto* b) { return a->layer < b->layer; });
  return tiles;
}

}  // namespace ldp::view
