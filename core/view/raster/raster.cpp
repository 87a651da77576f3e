#include "core/view/raster/raster.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "core/view/raster/occlusion.h"
#include "core/view/raster/raster_kernels.h"

namespace ldp::view {
namespace {

constexpr uint32_t kAllCells = (1U << kCells) - 1;
using kernels::Boxes;
using kernels::Candidates;
using kernels::QuadRow;
using kernels::Vertex;

void add(Candidates& out, int x, int y, int quad, bool wanted) {
  const int at = out.count;
  out.pixel[at] = x | y << 16;
  out.quad[at] = quad;
  out.count = at + static_cast<int>(wanted);  // or overwritten by the next one: no guess of the processor can go wrong
}

// Adds the pixels (x + dx, y + dy) of boxes `quads`; if `behind`, only those that show nothing nearer than the quad's
// nearest corner.
template <bool behind>
void add_pixels(const Boxes& boxes, uint32_t quads, int dx, int dy, const StripTarget& target, Candidates& out) {
  for (; quads != 0; quads &= quads - 1) {
    const int i = std::countr_zero(quads), x = boxes.x[i] + dx, y = boxes.y[i] + dy;
    bool wanted = true;
    if constexpr (behind) wanted = boxes.nearest[i] > target.opaque[target.pixel(x, y)].inverse_z;
    add(out, x, y, i, wanted);
  }
}

template <bool behind>
void add_two_by_two(const Boxes& boxes, uint32_t quads, const StripTarget& target, Candidates& out) {
  add_pixels<behind>(boxes, quads, 0, 0, target, out);
  add_pixels<behind>(boxes, quads & boxes.wide, 1, 0, target, out);
  add_pixels<behind>(boxes, quads & boxes.high, 0, 1, target, out);
  add_pixels<behind>(boxes, quads & boxes.wide & boxes.high, 1, 1, target, out);
}

void add_all(const Boxes& boxes, int i, const StripTarget& target, Candidates& out) {
  for (int y = boxes.y[i]; y <= boxes.bottom[i]; ++y)
    for (int x = boxes.x[i]; x <= boxes.right[i]; ++x)
      add(out, x, y, i, boxes.nearest[i] > target.opaque[target.pixel(x, y)].inverse_z);
}

// Draws rows of quads by draw(target, x, y, fragment).
template <void draw(StripTarget&, int, int, const Fragment&)>
class RowPainter {
 public:
  explicit RowPainter(StripTarget& target)
      : target_(target), clip_{target.x0, target.x0 + target.width - 1, target.height - 1} {}

  // Quads `wanted`, which are within [first, end), multiples of 8. `behind`: most of them lie behind what is drawn.
  // Calls prepare() before the first use of row.vertices.
  template <class Prepare>
  void paint(const QuadRow& row, int first, int end, uint32_t wanted, bool behind, Prepare prepare) {
    kernels_.find_boxes(row, first, end, clip_, boxes_);
    wanted &= boxes_.some;
    const uint32_t small = wanted & ~boxes_.large;
    (behind ? add_two_by_two<true> : add_two_by_two<false>)(boxes_, small & ~boxes_.beyond, target_, candidates_);
    const auto draw_some = [&] {
      if (candidates_.count == 0) return;
      prepare();
      draw_candidates(row);
    };
    for (uint32_t bits = small & boxes_.beyond; bits != 0; bits &= bits - 1) {
      if (candidates_.count + Candidates::kMostOfOneQuad > Candidates::kRoom) draw_some();
      add_all(boxes_, std::countr_zero(bits), target_, candidates_);
    }
    draw_some();
    for (uint32_t bits = wanted & boxes_.large; bits != 0; bits &= bits - 1) {
      prepare();
      draw_large(row, std::countr_zero(bits));
    }
  }

 private:
  void draw_candidates(const QuadRow& row) {
    kernels_.find_hits(row, candidates_, fragments_);
    const int count = std::exchange(candidates_.count, 0);
    for (int i = 0; i < count; ++i)
      draw(target_, candidates_.pixel[i] & 0xFFFF, candidates_.pixel[i] >> 16, fragments_[i]);
  }

  void draw_large(const QuadRow& row, int quad) {
    for (int y = boxes_.y[quad]; y <= boxes_.bottom[quad]; ++y)
      for (int x = boxes_.x[quad]; x <= boxes_.right[quad]; ++x)
        draw(target_, x, y, kernels_.find_hit(row, quad, x, y));
  }

  const kernels::Kernels& kernels_ = kernels::best();
  StripTarget& target_;
  kernels::Clip clip_;
  Boxes boxes_;
  Candidates candidates_;
  Fragment fragments_[Candidates::kRoom + Candidates::kPadding];
};

void draw_opaque(StripTarget& target, int x, int y, const Fragment& fragment) {
  Fragment nowhere;
  Fragment& shown = target.opaque[target.pixel(x, y)];
  (fragment.inverse_z > shown.inverse_z ? shown : nowhere) = fragment;
}

void draw_soft(StripTarget& target, int x, int y, const Fragment& fragment) {
  const size_t pixel = target.pixel(x, y);
  if (fragment.inverse_z <= target.opaque[pixel].inverse_z || alpha_of(fragment.colour) == 0) return;
  target.soft.push_back({fragment, target.first_soft[pixel]});
  target.first_soft[pixel] = static_cast<int32_t>(target.soft.size()) - 1;
}

bool is_visible(uint32_t cells, int x_in_tile, int y_in_tile) {
  return (cells >> cell_of(x_in_tile, y_in_tile) & 1) != 0;
}

// The bits of a row of quads that are in visible cells.
uint32_t row_mask(uint32_t visible_cells, int y_in_tile) {
  uint32_t mask = 0;
  for (int i = 0; i < kCellsAcross; ++i)
    if (is_visible(visible_cells, i * kCellPx, y_in_tile)) mask |= ((1U << kCellPx) - 1) << i * kCellPx;
  return mask;
}

// Vertices [first, first + count) of a row of a tile on the screen, with room for reading 8 from any one on.
struct VertexRow {
  ScreenRow numbers = {};
  Vertex vertices[kTilePx + 1] = {};
  int first = 0, count = 0;
  bool interleaved = false;

  void add_colours(const Rgba* colours) {
    if (!std::exchange(interleaved, true)) kernels::best().interleave(numbers, colours, count, first, vertices);
  }
};

// Columns of cells that a row of cells needs.
struct Span {
  int first = 0, end = 0;
};
Span span_of(uint32_t visible_cells, int y_in_tile) {
  const uint32_t cells = visible_cells >> cell_of(0, y_in_tile) & ((1U << kCellsAcross) - 1);
  if (cells == 0) return {};
  return {std::countr_zero(cells) * kCellPx, static_cast<int>(std::bit_width(cells)) * kCellPx};
}

class SolidPainter {
 public:
  SolidPainter(const ViewFrustum& frustum, StripTarget& target) : frustum_(frustum), painter_(target) {}

  void paint(const MeshTile& tile, uint32_t visible_cells) {
    for (int y = 0; y < kTilePx; y += kCellPx)
      paint_cells(tile, y, span_of(visible_cells, y), row_mask(visible_cells, y));
  }

 private:
  void paint_cells(const MeshTile& tile, int first_y, const Span& span, uint32_t mask) {
    int projected = -1;  // the last row that is
    for (int y = first_y; y < first_y + kCellPx; ++y) {
      const uint32_t solid = tile.solid[y] & mask;
      if (solid == 0) continue;
      if (projected != y) project(tile, y, span);
      project(tile, y + 1, span);
      projected = y + 1;
      const VertexRow &above = rows_[y & 1], &below = rows_[(y + 1) & 1];
      const ScreenRow &a = above.numbers, &b = below.numbers;
      const QuadRow quads{{above.vertices, above.vertices + 1, below.vertices, below.vertices + 1},
                          {a.x, a.x + 1, b.x, b.x + 1},
                          {a.y, a.y + 1, b.y, b.y + 1},
                          {a.inverse_z, a.inverse_z + 1, b.inverse_z, b.inverse_z + 1}};
      painter_.paint(quads, span.first, span.end, solid, tile.layer > 0, [&] {
        add_colours(tile, y);
        add_colours(tile, y + 1);
      });
    }
  }

  void project(const MeshTile& tile, int y, const Span& span) {
    VertexRow& row = rows_[y & 1];
    row.first = span.first;
    row.count = span.end - span.first + 1;
    row.interleaved = false;
    frustum_.project_row(tile.x0 + span.first, tile.y0 + y, row.count, &tile.w[MeshTile::index(span.first, y)],
                         row.first, row.numbers);
  }

  void add_colours(const MeshTile& tile, int y) {
    VertexRow& row = rows_[y & 1];
    row.add_colours(&tile.colour[MeshTile::index(row.first, y)]);
  }

  const ViewFrustum& frustum_;
  RowPainter<draw_opaque> painter_;
  VertexRow rows_[2];
};

template <void draw(StripTarget&, int, int, const Fragment&)>
class TornPainter {
 public:
  TornPainter(const ViewFrustum& frustum, StripTarget& target) : frustum_(frustum), painter_(target) {
    for (int k = 0; k < 4; ++k) {
      row_.vertices[k] = table_.vertices[k];
      row_.x[k] = table_.x[k];
      row_.y[k] = table_.y[k];
      row_.inverse_z[k] = table_.inverse_z[k];
    }
  }

  // The soft ones of a tile or the others, in its visible cells.
  void paint(const MeshTile& tile, bool soft, uint32_t visible_cells) {
    if (vertices_.size() < tile.torn_vertices.size()) vertices_.resize(tile.torn_vertices.size());
    const auto end_before = [](const uint16_t(&ends)[2 * kCells], int group) {
      return group > 0 ? int{ends[group - 1]} : 0;
    };
    for (uint32_t cells = visible_cells; cells != 0;) {
      const int cell = std::countr_zero(cells), run = std::countr_one(cells >> cell);
      const int first = cell + (soft ? kCells : 0), end = first + run;
      project(tile, end_before(tile.torn_vertices_end, first), end_before(tile.torn_vertices_end, end));
      paint_quads(tile, end_before(tile.torn_end, first), end_before(tile.torn_end, end));
      cells &= ~(((1U << run) - 1) << cell);
    }
  }

 private:
  void project(const MeshTile& tile, int first, int end) {
    for (; first < end; first += kTilePx) project_some(tile, first, std::min(kTilePx, end - first));
  }

  void project_some(const MeshTile& tile, int first, int count) {
    int x[kTilePx], y[kTilePx];
    float w[kTilePx];
    Rgba colours[kTilePx];
    for (int i = 0; i < count; ++i) {
      const TornVertex& vertex = tile.torn_vertices[static_cast<size_t>(first + i)];
      x[i] = tile.x0 + vertex.x_in_tile;
      y[i] = tile.y0 + vertex.y_in_tile;
      w[i] = vertex.w;
      colours[i] = vertex.colour;
    }
    ScreenRow screen;
    frustum_.project_scattered(count, x, y, w, screen);
    kernels_.interleave(screen, colours, count, 0, &vertices_[static_cast<size_t>(first)]);
  }

  void paint_quads(const MeshTile& tile, int first, int end) {
    for (; first < end; first += kRowQuads) {
      const int count = std::min(kRowQuads, end - first);
      kernels_.collect(vertices_.data(), &tile.torn[static_cast<size_t>(first)], count, table_);
      const auto wanted = static_cast<uint32_t>((uint64_t{1} << count) - 1);
      painter_.paint(row_, 0, (count + 7) / 8 * 8, wanted, tile.layer > 0, [] {});
    }
  }

  const kernels::Kernels& kernels_ = kernels::best();
  const ViewFrustum& frustum_;
  RowPainter<draw> painter_;
  std::vector<Vertex> vertices_;  // of a tile, those of its visible cells on the screen
  kernels::QuadTable table_;
  QuadRow row_;
};

}  // namespace

void StripTarget::clear(int strip_x0, int strip_width, int strip_height) {
  x0 = strip_x0;
  width = strip_width;
  height = strip_height;
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  opaque.assign(pixels, Fragment{});
  first_soft.assign(pixels, -1);
  soft.clear();
}

void draw(const std::vector<const MeshTile*>& tiles, const ViewFrustum& frustum, StripTarget& target) {
  const Window window = frustum.window(target.x0, target.x0 + target.width);
  std::vector<const MeshTile*> seen;
  for (const MeshTile* tile : tiles)
    if (frustum.sees(*tile, window)) seen.push_back(tile);
  std::optional<Occlusion> occlusion;  // by the strip and the layers before
  int layer = 0;
  if (!frustum.distorts()) occlusion.emplace(target);
  const auto visible_cells = [&](const MeshTile& tile) {
    return occlusion ? occlusion->visible_cells(frustum.bounds(tile)) : kAllCells;
  };
  SolidPainter solid(frustum, target);
  TornPainter<draw_opaque> torn(frustum, target);
  for (const MeshTile* tile : seen) {
    if (tile->layer != std::exchange(layer, tile->layer) && !frustum.distorts()) occlusion.emplace(target);
    const uint32_t visible = visible_cells(*tile);
    solid.paint(*tile, visible);
    torn.paint(*tile, false, visible);
  }
  TornPainter<draw_soft> soft(frustum, target);
  for (const MeshTile* tile : seen)
    if (tile->torn_end[kCells - 1] < tile->torn.size()) soft.paint(*tile, true, visible_cells(*tile));
}

Fragment blend(const StripTarget& target, size_t pixel) {
  const Fragment& back = target.opaque[pixel];
  if (target.first_soft[pixel] < 0) return back;
  constexpr size_t kMost = 16;  // beyond so many soft surfaces over each other nothing shows through
  std::array<Fragment, kMost> sorted;
  size_t count = 0;
  for (int32_t i = target.first_soft[pixel]; i >= 0 && count < kMost; i = target.soft[static_cast<size_t>(i)].next) {
    const Fragment& fragment = target.soft[static_cast<size_t>(i)].fragment;
    size_t at = count++;
    for (; at > 0 && sorted[at - 1].inverse_z < fragment.inverse_z; --at) sorted[at] = sorted[at - 1];
    sorted[at] = fragment;
  }
  float r = 0, g = 0, b = 0, through = 1;
  Fragment result;
  const auto add = [&](const Fragment& f) {
    const float share = through * static_cast<float>(alpha_of(f.colour)) / 255;
    r += share * static_cast<float>(f.colour & 255);
    g += share * static_cast<float>(f.colour >> 8 & 255);
    b += share * static_cast<float>(f.colour >> 16 & 255);
    through -= share;
    if (through <= 0.5F && result.inverse_z == kNothing) result.inverse_z = f.inverse_z;
  };
  for (size_t i = 0; i < count; ++i) add(sorted[i]);
  if (back.inverse_z != kNothing) add(back);
  const float opacity = 1 - through, scale = opacity > 0 ? 1 / opacity : 0;
  const auto byte = [](float value) { return static_cast<uint8_t>(std::min(value + 0.5F, 255.0F)); };
  result.colour = pack({byte(r * scale), byte(g * scale), byte(b * scale)}, byte(opacity * 255));
  return result;
}

}  // namespace ldp::view
