#include "core/export/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <unordered_map>

#include "core/view/tears.h"

namespace ldp {
namespace {

// Where a surface is torn it goes on by so many halves of a smallest cell, or under what is nearer and where its layer
// ends, so that a step aside opens no slit.
constexpr int kBeside = 1, kUnderneath = 3;

int sign(int v) { return (v > 0) - (v < 0); }

class SurfaceMaker {
 public:
  SurfaceMaker(const LayeredPanorama& panorama, const Layer& layer, const SurfacePart& part)
      : layer_(layer),
        step_(part.step),
        tolerance_(part.tolerance),
        connected_(view::joined_in_views(panorama.grid)),
        connected_alike_(view::joined_in_views(panorama.grid, view::kAlikeParallaxPx)),
        width_(panorama.grid.width),
        height_(panorama.grid.height),
        wraps_(panorama.grid.wraps) {
    for (SurfaceTolerance<double>* tolerance : {&connected_, &connected_alike_})
      tolerance->slack = std::max<double>(tolerance->slack, kSurfaceSlope * step_);
  }

  Surface run(int begin, int end, const Job& job) {
    const int last = wraps_ ? end : std::min(end, width_ - 1);
    for (int y = 0; y < height_ - 1; y += kSurfaceLargestCell) {
      job.check();
      for (int x = begin; x < last; x += kSurfaceLargestCell) split(x, y, kSurfaceLargestCell, last);
    }
    return std::move(surface_);
  }

 private:
  struct Corner {
    int x, y;
    bool present;
    int disparity, resolution;
    Rgb colour;
  };

  int column(int x) const { return x >= width_ ? x - width_ : x; }
  bool present(int x, int y) const { return layer_.coverage.at(column(x), y) != 0; }
  int disparity(int x, int y) const { return layer_.depth.disparity(column(x), y); }

  // What one code means there.
  int resolution(int x, int y) const {
    const DepthCodes& depth = layer_.depth;
    const BlockRange r = depth.range(column(x), y);
    return r.high - r.low;
  }

  bool joined(const Corner& a, const Corner& b) const {
    const SurfaceTolerance<double>& tolerance = view::look_alike(a.colour, b.colour) ? connected_alike_ : connected_;
    return a.present && b.present &&
           tolerance.same_surface(a.disparity, b.disparity, std::max(a.resolution, b.resolution));
  }

  Corner corner(int x, int y) const {
    if (!present(x, y)) return {x, y, false, 0, 0, {}};
    return {x, y, true, disparity(x, y), resolution(x, y), layer_.colour.at(column(x), y)};
  }

  void split(int x, int y, int size, int last) {
    if (x >= last || y >= height_ - 1) return;
    if (size == step_) return emit_smallest(x, y, std::min(x + size, last), std::min(y + size, height_ - 1));
    if (x + size <= last && y + size <= height_ - 1 && smooth(x, y, size)) return emit_cell(x, y, x + size, y + size);
    const int half = size / 2;
    for (const int dy : {0, half})
      for (const int dx : {0, half}) split(x + dx, y + dy, half, last);
  }

  // Every pixel of the cell is there, none is torn from the next, and all lie near the bilinear surface of the corners.
  bool smooth(int x0, int y0, int size) const {
    for (const int dy : {0, size})
      for (const int dx : {0, size})
        if (!present(x0 + dx, y0 + dy)) return false;
    const double d00 = disparity(x0, y0);
    const double d10 = disparity(x0 + size, y0);
    const double d01 = disparity(x0, y0 + size);
    const double d11 = disparity(x0 + size, y0 + size);
    for (int y = 0; y <= size; ++y)
      for (int x = 0; x <= size; ++x) {
        if (!present(x0 + x, y0 + y)) return false;
        const double s = static_cast<double>(x) / size;
        const double t = static_cast<double>(y) / size;
        const double flat = (1 - t) * ((1 - s) * d00 + s * d10) + t * ((1 - s) * d01 + s * d11);
        if (std::abs(flat - disparity(x0 + x, y0 + y)) > tolerance_) return false;
      }
    // Steep all over: a tear would have shown above as a step, unless the corners' own slope hides it.
    const double steepest =
        std::max({std::abs(d10 - d00), std::abs(d01 - d00), std::abs(d11 - d10), std::abs(d11 - d01)});
    return steepest <= kSurfaceSlope * size;
  }

  uint32_t shared_vertex(int x, int y) { return shared_vertex(x, y, 0, 0); }

  // On the way from a pixel, whose colour and depth it has, to a neighbour: dx and dy in half pixels.
  uint32_t shared_vertex(int x, int y, int dx, int dy) {
    const auto way = static_cast<uint64_t>((sign(dx) + 1) * 3 + sign(dy) + 1);
    const auto far = static_cast<uint64_t>(std::max(std::abs(dx), std::abs(dy)));
    const uint64_t key = far << 52 | way << 48 | static_cast<uint64_t>(y) << 24 | static_cast<uint64_t>(x);
    const auto [found, is_new] = vertex_at_.try_emplace(key, static_cast<uint32_t>(surface_.vertices.size()));
    if (is_new) {
      const auto px = static_cast<float>(x) + 0.5f;
      const auto py = static_cast<float>(y) + 0.5f;
      const auto d = static_cast<float>(disparity(x, y));
      surface_.vertices.push_back({px + 0.5f * static_cast<float>(dx), py + 0.5f * static_cast<float>(dy), px, py, d});
    }
    return found->second;
  }

  void emit(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    // Corners a b / c d; columns run clockwise seen from above, so from inside x grows to the right.
    for (const uint32_t i : {a, c, b, b, c, d}) surface_.triangles.push_back(i);
  }

  void emit_cell(int x0, int y0, int x1, int y1) {
    const uint32_t a = shared_vertex(x0, y0);
    const uint32_t b = shared_vertex(x1, y0);
    const uint32_t c = shared_vertex(x0, y1);
    const uint32_t d = shared_vertex(x1, y1);
    emit(a, b, c, d);
  }

  // The quad between four neighbouring pixels. If it is torn each of its surfaces has its part of it: corners of
  // another surface are taken from the nearest of its own.
  void emit_smallest(int x, int y, int x1, int y1) {
    const std::array<Corner, 4> corners = {corner(x, y), corner(x1, y), corner(x, y1), corner(x1, y1)};
    std::array<int, 4> group = {0, 1, 2, 3};
    const auto join = [&](size_t a, size_t b) {
      if (!joined(corners[a], corners[b])) return;
      const int from = std::max(group[a], group[b]);
      const int to = std::min(group[a], group[b]);
      std::replace(group.begin(), group.end(), from, to);
    };
    join(0, 1), join(0, 2), join(1, 3), join(2, 3);
    if (group == std::array<int, 4>{0, 0, 0, 0}) return emit_cell(x, y, x1, y1);
    for (int g = 0; g < 4; ++g)
      if (std::count(group.begin(), group.end(), g) > 0 && corners[static_cast<size_t>(g)].present)
        emit_part(corners, group, g);
  }

  void emit_part(const std::array<Corner, 4>& corners, const std::array<int, 4>& group, int own) {
    std::array<uint32_t, 4> index{};
    for (size_t i = 0; i < 4; ++i) {
      if (group[i] == own) {
        index[i] = shared_vertex(corners[i].x, corners[i].y);
        continue;
      }
      size_t from = i ^ 1;  // the neighbour in the row, in the column, or across
      if (group[from] != own) from = i ^ 2;
      if (group[from] != own) from = i ^ 3;
      const Corner& source = corners[from];
      const int reach = corners[i].present && corners[i].disparity <= source.disparity ? kBeside : kUnderneath;
      index[i] =
          shared_vertex(source.x, source.y, reach * (corners[i].x - source.x), reach * (corners[i].y - source.y));
    }
    emit(index[0], index[1], index[2], index[3]);
  }

  const Layer& layer_;
  int step_, tolerance_;
  SurfaceTolerance<double> connected_, connected_alike_;  // in steps of disparity
  int width_, height_;
  bool wraps_;
  Surface surface_;
  std::unordered_map<uint64_t, uint32_t> vertex_at_;
};

}  // namespace

Surface make_surface(const LayeredPanorama& panorama, size_t layer, const SurfacePart& part, const Job& job) {
  return SurfaceMaker(panorama, panorama.layers[layer], part).run(part.begin, part.end, job);
}

RgbImage spread_colour(const Layer& layer) {
  RgbImage image = layer.colour;
  for (int y = 0; y < image.height; ++y) {
    int last = -1;  // the present pixel to the left
    for (int x = 0; x <= image.width; ++x) {
      if (x < image.width && !layer.coverage.at(x, y)) continue;
      for (int gap = last + 1; gap < x; ++gap) {
        const bool from_left = x == image.width || (last >= 0 && gap - last <= x - gap);
        if (from_left && last < 0)
          image.at(gap, y) = y > 0 ? image.at(gap, y - 1) : Rgb{};
        else
          image.at(gap, y) = image.at(from_left ? last : x, y);
      }
      last = x;
    }
  }
  return image;
}

}  // namespace ldp
