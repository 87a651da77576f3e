#include "core/consistency/section.h"

#include <algorithm>

#include "core/base/exact_math.h"

namespace ldp::consistency {
namespace {

constexpr int kBlockPx = 16;      // columns that are seen or not
constexpr int kMarginBlocks = 3;  // surfaces go on underneath others by less
constexpr int kDepths = 8, kRows = 4;

using Seen = std::vector<bool>;  // by blocks

bool sees(const PanoramaGrid& grid, const Camera& camera, double theta, double v, double w) {
  const Eigen::Vector3d q = w * (grid.origin(theta) - camera.pose.centre) + grid.direction(theta, v);
  const Eigen::Vector3d in_camera = exact_transposed_product(camera.pose.world_from_camera, q);
  if (in_camera.z() < 1e-3) return false;
  const Intrinsics& k = camera.intrinsics;
  const double room = kBlockPx;
  const double x = k.fx * in_camera.x() / in_camera.z() + k.cx, y = k.fy * in_camera.y() / in_camera.z() + k.cy;
  return x > -room && x < k.width + room && y > -room && y < k.height + room;
}

Seen seen_by(const PanoramaGrid& grid, const Camera& camera) {
  const int blocks = (grid.width + kBlockPx - 1) / kBlockPx;
  Seen seen(static_cast<size_t>(blocks));
  for (int block = 0; block < blocks; ++block) {
    const double theta = grid.theta((block + 0.5) * kBlockPx);
    for (int i = 0; i < (kDepths + 1) * (kRows + 1) && !seen[static_cast<size_t>(block)]; ++i)
      seen[static_cast<size_t>(block)] =
          sees(grid, camera, theta, grid.v(grid.height * (i % (kRows + 1)) / double{kRows}),
               grid.inverse_depth(kDisparitySteps * (i / (kRows + 1)) / double{kDepths}));
  }
  return seen;
}

// The least section that holds all blocks seen, and a margin.
Section spanning(const PanoramaGrid& grid, const Seen& seen) {
  const int blocks = static_cast<int>(seen.size());
  int gap_begin = 0, gap = 0;  // the longest run of unseen blocks; past the end where the panorama wraps
  for (int begin = 0, run = 0; begin < (grid.wraps ? 2 : 1) * blocks; ++begin) {
    run = seen[static_cast<size_t>(begin % blocks)] ? 0 : run + 1;
    if (run > gap && run <= blocks) gap = run, gap_begin = begin - run + 1;
  }
  if (!grid.wraps) {
    const auto first = std::find(seen.begin(), seen.end(), true);
    const auto last = std::find(seen.rbegin(), seen.rend(), true);
    const int from = std::max(0, static_cast<int>(first - seen.begin()) - kMarginBlocks) * kBlockPx;
    const int to = std::min(blocks, static_cast<int>(seen.rend() - last) + kMarginBlocks) * kBlockPx;
    return {from, std::min(grid.width, to) - from};
  }
  if (gap <= 2 * kMarginBlocks + 1) return {0, grid.width};
  const int begin = (gap_begin + gap - kMarginBlocks) % blocks * kBlockPx;
  const int end = (gap_begin + kMarginBlocks) % blocks * kBlockPx;
  return {begin, end > begin ? end - begin : grid.width - begin + end};
}

Layer cut_out(const Layer& layer, const Section& section) {
  Layer part;
  const int height = layer.coverage.height, width = layer.coverage.width;
  const auto columns = [&](const auto& from, auto& to) {
    if (from.empty()) return;
    to = {section.columns, height};
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < section.columns; ++x) to.at(x, y) = from.at((section.begin + x) % width, y);
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
  part.depth.ranges = {section.columns, height};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < section.columns; ++x)
      part.depth.ranges.at(x, y) = layer.depth.range((section.begin + x) % width, y);
  return part;
}

}  // namespace

std::vector<CameraGroup> group_cameras(const PanoramaGrid& grid, const std::vector<Camera>& cameras,
                                       double most_share) {
  std::vector<CameraGroup> groups;
  Seen together;
  for (size_t i = 0; i < cameras.size(); ++i) {
    Seen seen = seen_by(grid, cameras[i]);
    if (std::find(seen.begin(), seen.end(), true) == seen.end()) seen.assign(seen.size(), true);
    Seen joined = seen;
    if (!groups.empty())
      for (size_t block = 0; block < seen.size(); ++block) joined[block] = seen[block] || together[block];
    const bool fits = !groups.empty() && spanning(grid, joined).columns <= most_share * grid.width;
    if (!fits) groups.push_back({i, i, {}});
    together = fits ? std::move(joined) : std::move(seen);
    groups.back().end = i + 1;
    groups.back().section = spanning(grid, together);
  }
  return groups;
}

LayeredPanorama cut_out(const LayeredPanorama& panorama, const Section& section) {
  LayeredPanorama part;
  part.grid = panorama.grid;
  part.grid.wraps = panorama.grid.wraps && section.columns == panorama.grid.width;
  part.grid.width = section.columns;
  part.grid.theta_left = panorama.grid.theta_left - section.begin * panorama.grid.theta_pitch;
  for (const Layer& layer : panorama.layers) part.layers.push_back(cut_out(layer, section));
  return part;
}

}  // namespace ldp::consistency
