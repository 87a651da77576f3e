#include "raster.h"

#include <algorithm>
#include <array>

namespace ldp::render {
namespace {

struct Quad {
  int32_t x[4], y[4];  // corners as in TornQuad
  float inverse_z[4];
};

// Twice the signed area of (from, to, p): positive to the right of the edge, which is inside (y runs down).
int64_t edge(const Quad& q, int from, int to, int32_t px, int32_t py) {
  return int64_t{q.x[to] - q.x[from]} * (py - q.y[from]) - int64_t{q.y[to] - q.y[from]} * (px - q.x[from]);
}

// Of two triangles that share an edge, exactly one owns the points on it.
bool owns(int64_t value, const Quad& q, int from, int to) {
  return value > 0 || (value == 0 && (q.y[to] < q.y[from] || (q.y[to] == q.y[from] && q.x[to] > q.x[from])));
}

// Position (s, t) in [0, 1]^2 of a pixel centre within a quad, and the inverse z there; false if it is outside, or on a
// half that is seen from behind. The quad is split along the diagonal from corner 1 to corner 2; inverse z is linear on
// the screen within each half. The three edge values of a triangle add up to its area.
struct Hit {
  float s, t, inverse_z;
};
bool hit(const Quad& q, int32_t px, int32_t py, Hit& out) {
  const float* z = q.inverse_z;
  const int64_t diagonal = edge(q, 1, 2, px, py);
  if (owns(diagonal, q, 1, 2)) {
    const int64_t top = edge(q, 0, 1, px, py), left = edge(q, 2, 0, px, py), area = diagonal + top + left;
    if (!owns(top, q, 0, 1) || !owns(left, q, 2, 0) || area <= 0) return false;
    const float scale = 1 / static_cast<float>(area);
    out.s = static_cast<float>(left) * scale, out.t = static_cast<float>(top) * scale;
    out.inverse_z = z[0] + out.s * (z[1] - z[0]) + out.t * (z[2] - z[0]);
    return true;
  }
  const int64_t bottom = edge(q, 3, 2, px, py), right = edge(q, 1, 3, px, py), area = bottom + right - diagonal;
  if (!owns(bottom, q, 3, 2) || !owns(right, q, 1, 3) || area <= 0) return false;
  const float scale = 1 / static_cast<float>(area), a = static_cast<float>(right) * scale,
              b = static_cast<float>(bottom) * scale;
  out.s = 1 - a, out.t = 1 - b;
  out.inverse_z = z[3] + a * (z[2] - z[3]) + b * (z[1] - z[3]);
  return true;
}

// Bilinear mix of four packed colours, each channel to 8 bits.
Rgba mix(const Rgba* c, float s, float t) {
  const auto si = static_cast<uint32_t>(s * 256 + 0.5F), ti = static_cast<uint32_t>(t * 256 + 0.5F);
  const uint32_t w3 = si * ti >> 8, w1 = si - w3, w2 = ti - w3, w0 = 256 - si - w2;
  constexpr uint32_t kEven = 0x00FF00FF, kHalf = 0x00800080;
  const uint32_t even = (c[0] & kEven) * w0 + (c[1] & kEven) * w1 + (c[2] & kEven) * w2 + (c[3] & kEven) * w3 + kHalf;
  const uint32_t odd =
      (c[0] >> 8 & kEven) * w0 + (c[1] >> 8 & kEven) * w1 + (c[2] >> 8 & kEven) * w2 + (c[3] >> 8 & kEven) * w3 + kHalf;
  return (even >> 8 & kEven) | (odd & ~kEven);
}

// Up to kTilePx quads at a time: the pixels whose centres lie in each one's box, and its largest inverse z.
struct Boxes {
  int32_t x0[kTilePx], x1[kTilePx], y0[kTilePx], y1[kTilePx];  // inclusive
  float nearest[kTilePx];
};

// Corner k of quad i is at [k][i].
struct CornerRows {
  const int32_t *x[4], *y[4];
  const float* inverse_z[4];
};

// Smallest and largest of four rows, number by number.
template <class T>
void range(const T* const (&rows)[4], int count, T* __restrict smallest, T* __restrict largest) {
  const T *a = rows[0], *b = rows[1], *c = rows[2], *d = rows[3];
  for (int i = 0; i < count; ++i) {
    const T ab_low = a[i] < b[i] ? a[i] : b[i], ab_high = a[i] < b[i] ? b[i] : a[i];
    const T cd_low = c[i] < d[i] ? c[i] : d[i], cd_high = c[i] < d[i] ? d[i] : c[i];
    smallest[i] = ab_low < cd_low ? ab_low : cd_low;
    largest[i] = ab_high < cd_high ? cd_high : ab_high;
  }
}

// The pixel centres of a range of positions within [first, last].
void pixels_within(int count, int32_t first, int32_t last, int32_t* __restrict low, int32_t* __restrict high) {
  static_assert(kSubPx == 1 << 8);
  for (int i = 0; i < count; ++i) {
    const int32_t begin = (low[i] + (kSubPx - 1)) >> 8, end = high[i] >> 8;
    low[i] = begin < first ? first : begin;
    high[i] = end > last ? last : end;
  }
}

// Fills the boxes of `count` quads; gives a mask of those not empty.
uint32_t find_boxes(const CornerRows& c, int count, const StripTarget& target, Boxes& boxes) {
  float farthest[kTilePx];
  int32_t on_screen[kTilePx];
  range(c.x, count, boxes.x0, boxes.x1);
  range(c.y, count, boxes.y0, boxes.y1);
  range(c.inverse_z, count, farthest, boxes.nearest);
  for (int i = 0; i < count; ++i) on_screen[i] = boxes.x0[i] != kOffScreen;
  pixels_within(count, target.x0, target.x0 + target.width - 1, boxes.x0, boxes.x1);
  pixels_within(count, 0, target.height - 1, boxes.y0, boxes.y1);
  for (int i = 0; i < count; ++i) on_screen[i] &= (boxes.x0[i] <= boxes.x1[i]) & (boxes.y0[i] <= boxes.y1[i]);
  uint32_t mask = 0;
  for (int i = 0; i < count; ++i) mask |= static_cast<uint32_t>(on_screen[i]) << i;
  return mask;
}

void draw_opaque(const Quad& q, const Rgba* c, const Boxes& boxes, int i, StripTarget& target) {
  for (int y = boxes.y0[i]; y <= boxes.y1[i]; ++y)
    for (int x = boxes.x0[i]; x <= boxes.x1[i]; ++x) {
      Fragment& pixel = target.opaque[target.pixel(x, y)];
      Hit at;
      if (boxes.nearest[i] <= pixel.inverse_z || !hit(q, x * kSubPx, y * kSubPx, at)) continue;
      if (at.inverse_z > pixel.inverse_z) pixel = {at.inverse_z, mix(c, at.s, at.t)};
    }
}

void draw_soft(const Quad& q, const Rgba* c, const Boxes& boxes, int i, StripTarget& target) {
  for (int y = boxes.y0[i]; y <= boxes.y1[i]; ++y)
    for (int x = boxes.x0[i]; x <= boxes.x1[i]; ++x) {
      const size_t pixel = target.pixel(x, y);
      const float behind = target.opaque[pixel].inverse_z;
      Hit at;
      if (boxes.nearest[i] <= behind || !hit(q, x * kSubPx, y * kSubPx, at) || at.inverse_z <= behind) continue;
      const Rgba colour = mix(c, at.s, at.t);
      if (alpha_of(colour) == 0) continue;
      target.soft.push_back({{at.inverse_z, colour}, target.first_soft[pixel]});
      target.first_soft[pixel] = static_cast<int32_t>(target.soft.size()) - 1;
    }
}

void draw_solid(const Mesh& mesh, const MeshTile& tile, const ViewFrustum& frustum, StripTarget& target) {
  const MeshLayer& layer = mesh.layers[static_cast<size_t>(tile.layer)];
  const int columns = std::min(kTilePx + 1, layer.w.width - tile.x0);
  ScreenRow rows[2];
  const auto load = [&](int y) { frustum.project_row(tile.x0, y, columns, &layer.w.at(tile.x0, y), rows[y & 1]); };
  Boxes boxes;
  int loaded = -1;
  for (int y = tile.y0; y < std::min(tile.y0 + kTilePx, layer.w.height - 1); ++y) {
    const uint32_t solid = tile.solid[y - tile.y0];
    if (solid == 0) continue;
    if (loaded != y) load(y);
    load(y + 1);
    loaded = y + 1;
    const ScreenRow &a = rows[y & 1], &b = rows[(y + 1) & 1];
    const Rgba *above = &layer.colour.at(tile.x0, y), *below = &layer.colour.at(tile.x0, y + 1);
    const CornerRows corners{{a.x, a.x + 1, b.x, b.x + 1},
                             {a.y, a.y + 1, b.y, b.y + 1},
                             {a.inverse_z, a.inverse_z + 1, b.inverse_z, b.inverse_z + 1}};
    for (uint32_t bits = find_boxes(corners, columns - 1, target, boxes) & solid; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      const Quad q{{a.x[i], a.x[i + 1], b.x[i], b.x[i + 1]},
                   {a.y[i], a.y[i + 1], b.y[i], b.y[i + 1]},
                   {a.inverse_z[i], a.inverse_z[i + 1], b.inverse_z[i], b.inverse_z[i + 1]}};
      const Rgba c[4] = {above[i], above[i + 1], below[i], below[i + 1]};
      draw_opaque(q, c, boxes, i, target);
    }
  }
}

// Torn quads [begin, end) of a tile, some at a time: corner k of all of them, then corner k + 1.
template <class Draw>
void draw_torn(const MeshTile& tile, size_t begin, size_t end, const ViewFrustum& frustum, StripTarget& target,
               Draw draw_quad) {
  constexpr int kBatch = kTilePx / 4;
  int x[4 * kBatch], y[4 * kBatch];
  float w[4 * kBatch];
  ScreenRow screen;
  Boxes boxes;
  for (; begin < end; begin += kBatch) {
    const int count = static_cast<int>(std::min<size_t>(kBatch, end - begin));
    const TornQuad* quads = &tile.torn[begin];
    for (int k = 0; k < 4; ++k)
      for (int i = 0; i < kBatch; ++i) {
        const TornQuad& quad = quads[std::min(i, count - 1)];
        x[k * kBatch + i] = tile.x0 + quad.x_in_tile + (k & 1);
        y[k * kBatch + i] = tile.y0 + quad.y_in_tile + (k >> 1);
        w[k * kBatch + i] = quad.w[k];
      }
    frustum.project_scattered(4 * kBatch, x, y, w, screen);
    CornerRows corners;
    for (int k = 0; k < 4; ++k) {
      corners.x[k] = screen.x + k * kBatch;
      corners.y[k] = screen.y + k * kBatch;
      corners.inverse_z[k] = screen.inverse_z + k * kBatch;
    }
    for (uint32_t bits = find_boxes(corners, count, target, boxes); bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      Quad q;
      for (int k = 0; k < 4; ++k)
        q.x[k] = corners.x[k][i], q.y[k] = corners.y[k][i], q.inverse_z[k] = corners.inverse_z[k][i];
      draw_quad(q, quads[i].colour, boxes, i, target);
    }
  }
}

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

void draw(const Mesh& mesh, const std::vector<const MeshTile*>& tiles, const ViewFrustum& frustum,
          StripTarget& target) {
  const Window window = frustum.window(target.x0, target.x0 + target.width);
  std::vector<const MeshTile*> seen;
  for (const MeshTile* tile : tiles)
    if (frustum.sees(*tile, window)) seen.push_back(tile);
  for (const MeshTile* tile : seen) {
    draw_solid(mesh, *tile, frustum, target);
    draw_torn(*tile, 0, tile->opaque_torn, frustum, target, draw_opaque);
  }
  for (const MeshTile* tile : seen) draw_torn(*tile, tile->opaque_torn, tile->torn.size(), frustum, target, draw_soft);
}

Blended blend(const StripTarget& target, size_t pixel) {
  const Fragment& back = target.opaque[pixel];
  if (target.first_soft[pixel] < 0) return {back.colour, back.inverse_z};
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
  Blended result;
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

}  // namespace ldp::render
