#include "core/view/strip_renderer.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/base/exact_math.h"
#include "core/view/draw_view.h"
#include "core/view/view_tuning.h"

namespace ldp {
namespace {

constexpr int kStripColumns = view::kStripTiles * view::kTilePx;
constexpr int kMarginColumns = view::kTilePx;  // surfaces go on underneath others by less

// Neighbouring columns; in a panorama that wraps they may go on past its ends.
struct Section {
  int begin = 0, columns = 0;
};

bool sees(const PanoramaGrid& grid, const Camera& camera, double theta, double v, double w) {
  const Eigen::Vector3d q = w * (grid.origin(theta) - camera.pose.centre) + grid.direction(theta, v);
  const Eigen::Vector3d in_camera = exact_transposed_product(camera.pose.world_from_camera, q);
  if (in_camera.z() < view::kNearestZ) return false;
  const Intrinsics& k = camera.intrinsics;
  const double room = 2 * view::kAskedColumns;
  const double x = k.fx * in_camera.x() / in_camera.z() + k.cx, y = k.fy * in_camera.y() / in_camera.z() + k.cy;
  return x > -room && x < k.width + room && y > -room && y < k.height + room;
}

// Of a column, at some of its heights and depths.
bool sees_column(const PanoramaGrid& grid, const Camera& camera, double theta) {
  for (int depth = 0; depth <= view::kAskedDepths; ++depth)
    for (int row = 0; row <= view::kAskedRows; ++row)
      if (sees(grid, camera, theta, grid.v(grid.height * row / double{view::kAskedRows}),
               grid.inverse_depth(kDisparitySteps * depth / double{view::kAskedDepths})))
        return true;
  return false;
}

bool sees_columns(const PanoramaGrid& grid, const Camera& camera, int begin, int end) {
  for (int column = begin; column < end + view::kAskedColumns; column += view::kAskedColumns)
    if (sees_column(grid, camera, grid.theta(std::min(column, end)))) return true;
  return false;
}

Layer cut_out(const Layer& layer, const Section& section) {
  Layer part;
  const int height = layer.coverage.height, width = layer.coverage.width;
  const auto wrapped = [&](int x) { return ((section.begin + x) % width + width) % width; };
  const auto columns = [&](const auto& from, auto& to) {
    if (from.empty()) return;
    to = {section.columns, height};
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < section.columns; ++x) to.at(x, y) = from.at(wrapped(x), y);
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
    for (int x = 0; x < section.columns; ++x) part.depth.ranges.at(x, y) = layer.depth.range(wrapped(x), y);
  return part;
}

// A panorama of its own, with the same rays, that does not wrap.
LayeredPanorama cut_out(const LayeredPanorama& panorama, const Section& section) {
  LayeredPanorama part;
  part.grid = panorama.grid;
  part.grid.wraps = false;
  part.grid.width = section.columns;
  part.grid.theta_left = panorama.grid.theta_left - section.begin * panorama.grid.theta_pitch;
  for (const Layer& layer : panorama.layers) part.layers.push_back(cut_out(layer, section));
  return part;
}

}  // namespace

struct StripRenderer::Prepared {
  const LayeredPanorama& panorama;
  std::map<int, view::Mesh> strips;  // by their first columns
  ScratchPool<view::StripTarget> targets;

  int last_quad() const { return panorama.grid.wraps ? panorama.grid.width : panorama.grid.width - 1; }

  view::Mesh strip(int begin, const Job& job) const {
    const PanoramaGrid& grid = panorama.grid;
    const int end = std::min(begin + kStripColumns, last_quad());
    int from = begin - kMarginColumns, to = end + 1 + kMarginColumns;
    if (!grid.wraps) from = std::max(0, from), to = std::min(grid.width, to);
    const Section section{from, to - from};
    const int first = begin - from;
    view::Mesh mesh = view::build_mesh(cut_out(panorama, section), first, first + end - begin, job);
    for (view::MeshTile& tile : mesh.tiles) tile.x0 += from;
    return mesh;
  }

  void prepare_for(const Camera& camera, const Job& job) {
    std::vector<int> seen;
    for (int begin = 0; begin < last_quad(); begin += kStripColumns)
      if (sees_columns(panorama.grid, camera, begin, std::min(begin + kStripColumns, last_quad())))
        seen.push_back(begin);
    std::erase_if(strips, [&](const auto& s) { return std::find(seen.begin(), seen.end(), s.first) == seen.end(); });
    std::erase_if(seen, [&](int begin) { return strips.contains(begin); });
    std::vector<view::Mesh> made(seen.size());
    parallel_for(job, static_cast<int>(seen.size()),
                 [&](int i) { made[static_cast<size_t>(i)] = strip(seen[static_cast<size_t>(i)], job); });
    for (size_t i = 0; i < seen.size(); ++i) strips.emplace(seen[i], std::move(made[i]));
  }
};

StripRenderer::StripRenderer(const LayeredPanorama& panorama) : prepared_(new Prepared{panorama, {}, {}}) {}

StripRenderer::~StripRenderer() = default;

void StripRenderer::prepare(const Camera& camera, const Job& job) {
  view::check_camera(camera);
  prepared_->prepare_for(camera, job);
}

View StripRenderer::render(const Camera& camera, const RenderOptions& options, const Job& job) {
  prepare(camera, job);
  const int layers = static_cast<int>(prepared_->panorama.layers.size());
  std::vector<const view::MeshTile*> tiles;
  for (const auto& [begin, mesh] : prepared_->strips)
    for (const view::MeshTile& tile : mesh.tiles)
      if (options.layers >= layers || tile.layer < options.layers) tiles.push_back(&tile);
  std::stable_sort(tiles.begin(), tiles.end(), [](const auto* a, const auto* b) { return a->layer < b->layer; });
  const PanoramaGrid& grid = prepared_->panorama.grid;
  const view::ViewFrustum frustum(grid, 0, grid.height, camera);
  return view::draw_view(tiles, grid, frustum, camera, options, prepared_->targets, job);
}

}  // namespace ldp
