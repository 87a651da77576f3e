#include "raster.h"

#include <algorithm>

namespace ldp::render {
namespace {

struct Quad {
  int32_t x[4], y[4];  // corners as in TornQuad
  float inverse_z[4];
};

template <class Int>
struct Triangle {
  Int ax, ay, bx, by, cx, cy;  // clockwise on the screen (y down)
  Int area() const { return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax); }
};

// Twice the signed area of (from, to, p): positive to the right of the edge, which is inside.
template <class Int>
Int edge(Int fx, Int fy, Int tx, Int ty, Int px, Int py) {
  return (tx - fx) * (py - fy) - (ty - fy) * (px - fx);
}

// Of two triangles that share an edge, exactly one owns the points on it.
template <class Int>
bool owns(Int value, Int fx, Int fy, Int tx, Int ty) {
  return value > 0 || (value == 0 && (ty < fy || (ty == fy && tx > fx)));
}

// Calls emit(b, c, inverse area) with the unnormalised barycentric weights of the second and third corner.
template <class Int, class Emit>
void at_pixel(const Triangle<Int>& t, Int px, Int py, Emit emit) {
  const Int c = edge(t.ax, t.ay, t.bx, t.by, px, py);
  const Int a = edge(t.bx, t.by, t.cx, t.cy, px, py);
  const Int b = edge(t.cx, t.cy, t.ax, t.ay, px, py);
  if (owns(c, t.ax, t.ay, t.bx, t.by) && owns(a, t.bx, t.by, t.cx, t.cy) && owns(b, t.cx, t.cy, t.ax, t.ay))
    emit(static_cast<float>(b), static_cast<float>(c));
}

struct PixelBox {
  int x0, x1, y0, y1;  // inclusive
};

// Calls emit(x, y, inverse_z, s, t) for every pixel centre inside the quad's front-facing halves; (s, t) in [0, 1]^2 is
// the position within the quad. The quad is split along the diagonal from corner 1 to corner 2.
template <class Int, class Emit>
void cover(const Quad& q, const PixelBox& box, Emit emit) {
  const auto triangle = [&](int a, int b, int c) {
    return Triangle<Int>{q.x[a], q.y[a], q.x[b], q.y[b], q.x[c], q.y[c]};
  };
  const Triangle<Int> upper = triangle(0, 1, 2), lower = triangle(3, 2, 1);
  const Int upper_area = upper.area(), lower_area = lower.area();
  if (upper_area <= 0 && lower_area <= 0) return;
  for (int y = box.y0; y <= box.y1; ++y)
    for (int x = box.x0; x <= box.x1; ++x) {
      const Int px = static_cast<Int>(x) * kSubPx, py = static_cast<Int>(y) * kSubPx;
      if (upper_area > 0)
        at_pixel<Int>(upper, px, py, [&](float b, float c) {
          const float scale = 1 / static_cast<float>(upper_area), s = b * scale, t = c * scale;
          emit(x, y, q.inverse_z[0] + s * (q.inverse_z[1] - q.inverse_z[0]) + t * (q.inverse_z[2] - q.inverse_z[0]), s,
               t);
        });
      if (lower_area > 0)
        at_pixel<Int>(lower, px, py, [&](float b, float c) {
          const float scale = 1 / static_cast<float>(lower_area), s = b * scale, t = c * scale;
          emit(x, y, q.inverse_z[3] + s * (q.inverse_z[2] - q.inverse_z[3]) + t * (q.inverse_z[1] - q.inverse_z[3]),
               1 - s, 1 - t);
        });
    }
}

// Pixel centres (multiples of kSubPx) inside the corners' box and the strip; false if there is none.
bool pixel_box(const Quad& q, const StripTarget& target, PixelBox& box, bool& small) {
  const int32_t x_min = std::min(std::min(q.x[0], q.x[1]), std::min(q.x[2], q.x[3]));
  if (x_min == kOffScreen) return false;
  const int32_t x_max = std::max(std::max(q.x[0], q.x[1]), std::max(q.x[2], q.x[3]));
  const int32_t y_min = std::min(std::min(q.y[0], q.y[1]), std::min(q.y[2], q.y[3]));
  const int32_t y_max = std::max(std::max(q.y[0], q.y[1]), std::max(q.y[2], q.y[3]));
  box.x0 = std::max((x_min + kSubPx - 1) >> 8, target.x0);
  box.x1 = std::min(x_max >> 8, target.x0 + target.width - 1);
  box.y0 = std::max((y_min + kSubPx - 1) >> 8, 0);
  box.y1 = std::min(y_max >> 8, target.height - 1);
  constexpr int32_t kSmall = 60 * kSubPx;  // products of differences stay in 32 bits
  small = x_max - x_min < kSmall && y_max - y_min < kSmall;
  return box.x0 <= box.x1 && box.y0 <= box.y1;
}
static_assert(kSubPx == 1 << 8);

// Bilinear mix of four packed colours, each channel to 8 bits.
Rgba mix(Rgba c0, Rgba c1, Rgba c2, Rgba c3, float s, float t) {
  const auto si = static_cast<uint32_t>(s * 256 + 0.5F), ti = static_cast<uint32_t>(t * 256 + 0.5F);
  const uint32_t w3 = si * ti >> 8, w1 = si - w3, w2 = ti - w3, w0 = 256 - si - w2;
  constexpr uint32_t kEven = 0x00FF00FF, kHalf = 0x00800080;
  const uint32_t even = (c0 & kEven) * w0 + (c1 & kEven) * w1 + (c2 & kEven) * w2 + (c3 & kEven) * w3 + kHalf;
  const uint32_t odd =
      (c0 >> 8 & kEven) * w0 + (c1 >> 8 & kEven) * w1 + (c2 >> 8 & kEven) * w2 + (c3 >> 8 & kEven) * w3 + kHalf;
  return (even >> 8 & kEven) | (odd & ~kEven);
}

template <class Emit>
void rasterise(const Quad& q, const StripTarget& target, Emit emit) {
  PixelBox box;
  bool small;
  if (!pixel_box(q, target, box, small)) return;
  if (small)
    cover<int32_t>(q, box, emit);
  else
    cover<int64_t>(q, box, emit);
}

void draw_opaque(const Quad& q, const Rgba* c, StripTarget& target) {
  rasterise(q, target, [&](int x, int y, float inverse_z, float s, float t) {
    Fragment& pixel =
        target.opaque[static_cast<size_t>(y) * static_cast<size_t>(target.width) + static_cast<size_t>(x - target.x0)];
    if (inverse_z > pixel.inverse_z) pixel = {inverse_z, mix(c[0], c[1], c[2], c[3], s, t)};
  });
}

void insert_soft(StripTarget& target, size_t pixel, const Fragment& fragment) {
  Fragment* list = &target.soft[pixel * kSoftDepth];
  uint8_t& count = target.soft_count[pixel];
  int at = count;
  while (at > 0 && list[at - 1].inverse_z < fragment.inverse_z) --at;
  if (at == kSoftDepth) return;
  for (int i = std::min<int>(count, kSoftDepth - 1); i > at; --i) list[i] = list[i - 1];
  list[at] = fragment;
  count = static_cast<uint8_t>(std::min<int>(count + 1, kSoftDepth));
}

void draw_soft(const Quad& q, const Rgba* c, StripTarget& target) {
  rasterise(q, target, [&](int x, int y, float inverse_z, float s, float t) {
    const size_t pixel =
        static_cast<size_t>(y) * static_cast<size_t>(target.width) + static_cast<size_t>(x - target.x0);
    if (inverse_z <= target.opaque[pixel].inverse_z) return;
    const Rgba colour = mix(c[0], c[1], c[2], c[3], s, t);
    if (alpha_of(colour) != 0) insert_soft(target, pixel, {inverse_z, colour});
  });
}

Quad place(const TornQuad& torn, const MeshTile& tile, const ViewFrustum& frustum) {
  Quad q;
  for (int i = 0; i < 4; ++i)
    frustum.project(tile.x0 + torn.x_in_tile + (i & 1), tile.y0 + torn.y_in_tile + (i >> 1), torn.w[i], q.x[i], q.y[i],
                    q.inverse_z[i]);
  return q;
}

void draw_solid(const Mesh& mesh, const MeshTile& tile, const ViewFrustum& frustum, StripTarget& target) {
  const MeshLayer& layer = mesh.layers[static_cast<size_t>(tile.layer)];
  const int columns = std::min(kTilePx + 1, mesh.width - tile.x0 + (mesh.wraps ? 1 : 0));
  ScreenRow rows[2];
  Rgba colours[2][kTilePx + 1];
  const auto load = [&](int y, int slot) {
    float w[kTilePx + 1];
    const size_t begin = layer.w.index(tile.x0, y);
    const int stored = std::min(columns, mesh.width - tile.x0);
    std::copy_n(&layer.w.samples[begin], stored, w);
    std::copy_n(&layer.colour.samples[begin], stored, colours[slot]);
    if (stored < columns) w[stored] = layer.w.at(0, y), colours[slot][stored] = layer.colour.at(0, y);
    frustum.project_row(tile.x0, y, columns, w, rows[slot]);
  };
  int loaded = -1;
  const int y_end = std::min(kTilePx, mesh.height - 1 - tile.y0);
  for (int j = 0; j < y_end; ++j) {
    uint32_t bits = tile.solid[j];
    if (bits == 0) continue;
    if (loaded != j) load(tile.y0 + j, j & 1);
    load(tile.y0 + j + 1, (j + 1) & 1);
    loaded = j + 1;
    const ScreenRow &upper = rows[j & 1], &lower = rows[(j + 1) & 1];
    const Rgba *above = colours[j & 1], *below = colours[(j + 1) & 1];
    for (; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      const Quad q{{upper.x[i], upper.x[i + 1], lower.x[i], lower.x[i + 1]},
                   {upper.y[i], upper.y[i + 1], lower.y[i], lower.y[i + 1]},
                   {upper.inverse_z[i], upper.inverse_z[i + 1], lower.inverse_z[i], lower.inverse_z[i + 1]}};
      const Rgba c[4] = {above[i], above[i + 1], below[i], below[i + 1]};
      draw_opaque(q, c, target);
    }
  }
}

}  // namespace

StripTarget::StripTarget(int strip_x0, int strip_width, int strip_height)
    : x0(strip_x0), width(strip_width), height(strip_height) {
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  opaque.resize(pixels);
  soft_count.resize(pixels);
  soft.resize(pixels * kSoftDepth);
}

void draw(const Mesh& mesh, const ViewFrustum& frustum, int layers, StripTarget& target) {
  const Window window = frustum.window(target.x0, target.x0 + target.width);
  std::vector<const MeshTile*> seen;
  for (const MeshTile& tile : mesh.tiles)
    if (tile.layer < layers && frustum.sees(tile, window)) seen.push_back(&tile);
  for (const MeshTile* tile : seen) {
    draw_solid(mesh, *tile, frustum, target);
    for (size_t i = 0; i < tile->opaque_torn; ++i)
      draw_opaque(place(tile->torn[i], *tile, frustum), tile->torn[i].colour, target);
  }
  for (const MeshTile* tile : seen)
    for (size_t i = tile->opaque_torn; i < tile->torn.size(); ++i)
      draw_soft(place(tile->torn[i], *tile, frustum), tile->torn[i].colour, target);
}

Blended blend(const StripTarget& target, size_t pixel) {
  const Fragment& back = target.opaque[pixel];
  const int count = target.soft_count[pixel];
  if (count == 0) return {back.colour, back.inverse_z};
  const Fragment* list = &target.soft[pixel * kSoftDepth];
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
  for (int i = 0; i < count; ++i) add(list[i]);
  if (back.inverse_z != kNothing) add(back);
  const float opacity = 1 - through, scale = opacity > 0 ? 1 / opacity : 0;
  const auto byte = [](float value) { return static_cast<uint8_t>(std::min(value + 0.5F, 255.0F)); };
  result.colour = pack({byte(r * scale), byte(g * scale), byte(b * scale)}, byte(opacity * 255));
  return result;
}

}  // namespace ldp::render
