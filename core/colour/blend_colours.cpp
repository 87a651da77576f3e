#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/colour/blending.h"
#include "core/colour/colour.h"
#include "core/colour/colour_tuning.h"
#include "core/colour/photo_sampler.h"
#include "core/colour/seam_levelling.h"
#include "core/geometry/same_surface.h"

namespace ldp::colour {
namespace {

using namespace tuning;

constexpr int kRowsAtOnce = 16;
constexpr SurfaceTolerance<int> kOneSurface{kDisparitySteps / (kLabels - 1) - 1};  // less than a label

// One pixel of a border, met while its neighbour's photograph is in memory. Small: where a camera moves forward, there
// are millions.
struct SeamPixel {
  uint16_t x = 0;  // no file is wider
  uint16_t other : 14 = 0, side : 2 = 0;
  std::array<int16_t, 3> seen{};
};

std::array<int16_t, 3> narrowed(const Colour& c) {
  const auto channel = [](int v) { return static_cast<int16_t>(std::clamp(v, INT16_MIN, INT16_MAX)); };
  return {channel(c[0]), channel(c[1]), channel(c[2])};
}

SeamPixel seam_pixel(int x, int other, int side, const Colour& seen) {
  SeamPixel pixel;
  pixel.x = static_cast<uint16_t>(x);
  pixel.other = other & kMostSources;
  pixel.side = side & 3;
  pixel.seen = narrowed(seen);
  return pixel;
}

Rgb stored(const Colour& c) {
  const auto channel = [](int v) {
    return static_cast<uint8_t>(std::clamp((v + kColourSteps / 2) / kColourSteps, 0, 255));
  };
  return {channel(c[0]), channel(c[1]), channel(c[2])};
}

// A pixel, and who sees it.
struct Voxel {
  int x = 0, y = 0;
  double w = 0;  // inverse depth
  int source = 0;
  uint8_t neighbours = 0;

  bool seen_by(int photo) const {
    const int offset = photo - source;
    if (offset == 0) return true;
    return -kViewsAside <= offset && offset <= kViewsAside && (neighbours >> neighbour_bit(offset) & 1) != 0;
  }
};

// The photographs around the one that is taken from, in memory.
class OpenPhotographs {
 public:
  OpenPhotographs(const PanoramaGrid& grid, const Photographs& photographs)
      : grid_(grid), photographs_(photographs), open_(photographs.cameras.size()) {}

  void load(int index) {
    const auto i = static_cast<size_t>(index);
    const DisplayExposure* local = photographs_.local.empty() ? nullptr : &photographs_.local;
    open_[i].emplace(Open{photographs_.frames.load(photographs_.frame_of_camera[i]),
                          PhotoSampler(grid_, photographs_.cameras[i], photographs_.gains[i], local)});
  }
  void close(int index) {
    if (index >= 0) open_[static_cast<size_t>(index)].reset();
  }

  Colour sample(int index, const Voxel& voxel) const {
    const Open& open = *open_[static_cast<size_t>(index)];
    return open.sampler.sample(open.picture, voxel.x, voxel.y, voxel.w);
  }

  double distrust(int index, const Voxel& voxel) const {
    const Open& open = *open_[static_cast<size_t>(index)];
    return open.sampler.distrust(open.picture, voxel.x, voxel.y, voxel.w);
  }

  // What those around photograph `index` show of a voxel that they see: visit(neighbour, colour).
  template <typename Visit>
  void for_neighbours(int index, const Voxel& voxel, const Visit& visit) const {
    const int last = static_cast<int>(open_.size()) - 1;
    for (int other = std::max(0, index - kViewsAside); other <= std::min(last, index + kViewsAside); ++other) {
      if (other == index || !voxel.seen_by(other)) continue;
      const Open& open = *open_[static_cast<size_t>(other)];
      if (const auto c = open.sampler.sample_if_inside(open.picture, voxel.x, voxel.y, voxel.w))
        visit(neighbour_bit(other - index), *c);
    }
  }

 private:
  struct Open {
    RgbImage picture;
    PhotoSampler sampler;
  };

  const PanoramaGrid& grid_;
  const Photographs& photographs_;
  std::vector<std::optional<Open>> open_;  // one per camera
};

// What photograph `index` and its neighbours agree on, with its brightness.
Colour own_consensus(const OpenPhotographs& open, const BrightnessDifferences& differences, int index,
                     const Voxel& voxel) {
  const Colour own = open.sample(index, voxel);
  std::array<Colour, 1 + kNeighbourViews> samples{own};
  size_t count = 1;
  open.for_neighbours(index, voxel, [&](int neighbour, const Colour& c) {
    const auto brighter = differences.at(voxel.x, voxel.y, neighbour);
    if (!brighter) return;
    for (size_t k = 0; k < 3; ++k) samples[count][k] = c[k] - (*brighter)[k];
    ++count;
  });
  return consensus({samples.data(), count});
}

// What the neighbours alone show, with the brightness of photograph `index` where it is known: those that see the
// voxel, or if none does those that see where it is.
std::optional<Colour> others_consensus(const OpenPhotographs& open, const BrightnessDifferences& differences, int index,
                                       Voxel voxel) {
  for (const uint8_t neighbours : {voxel.neighbours, uint8_t{(1 << kNeighbourViews) - 1}}) {
    voxel.neighbours = neighbours;
    std::array<Colour, kNeighbourViews> samples{};
    size_t count = 0;
    open.for_neighbours(index, voxel, [&](int neighbour, const Colour& c) {
      const Colour brighter = differences.at(voxel.x, voxel.y, neighbour).value_or(Colour{});
      for (size_t k = 0; k < 3; ++k) samples[count][k] = c[k] - brighter[k];
      ++count;
    });
    if (count > 0) return consensus({samples.data(), count});
  }
  return {};
}

// What photographs agree on; the less photograph `index` is to be trusted, the more what others do.
Colour consensus_colour(const OpenPhotographs& open, const BrightnessDifferences& differences, int index,
                        const Voxel& voxel) {
  Colour colour = own_consensus(open, differences, index, voxel);
  const double distrust = open.distrust(index, voxel);
  if (distrust == 0) return colour;
  const auto others = others_consensus(open, differences, index, voxel);
  if (!others) return colour;
  for (size_t k = 0; k < 3; ++k) colour[k] += static_cast<int>(distrust * ((*others)[k] - colour[k]));
  return colour;
}

class LayerBlend {
 public:
  LayerBlend(const PanoramaGrid& grid, const ColourTask& task) : grid_(grid), task_(task) {
    seams_of_row_.resize(static_cast<size_t>(grid.height));
    find_spans();
  }

  // Adds by how much each neighbour is brighter than photograph `index`, where a cell is taken from it.
  void compare(const OpenPhotographs& open, const BrightnessDifferences& cells, int index, int column, int row,
               std::array<std::vector<Colour>, kNeighbourViews>& samples) const {
    const int end_x = std::min(cells.begin_x(column + 1), span_of(index).end);
    for (int y = cells.begin_y(row); y < cells.begin_y(row + 1); y += kCompareEvery)
      for (int x = cells.begin_x(column); x < end_x; x += kCompareEvery) {
        if (task_.source->at(x, y) != index) continue;
        const Voxel voxel = at(x, y);
        if (voxel.neighbours == 0 || open.distrust(index, voxel) > 0.5) continue;
        const Colour own = open.sample(index, voxel);
        open.for_neighbours(index, voxel, [&](int neighbour, const Colour& c) {
          samples[static_cast<size_t>(neighbour)].push_back({c[0] - own[0], c[1] - own[1], c[2] - own[2]});
        });
      }
  }

  // What is taken from photograph `index`.
  void blend_row(const OpenPhotographs& open, const BrightnessDifferences& differences, int index, int y) {
    const Span span = span_of(index);
    for (int x = span.begin; x < span.end; ++x) {
      const int source = task_.source->at(x, y);
      if (source == kNoSource) continue;
      const bool own = source == index;
      const auto side = own ? std::nullopt : side_of(x, y, index);
      if (!own && !side) continue;
      const Voxel voxel = at(x, y);
      const Colour c = consensus_colour(open, differences, index, voxel);
      if (own)
        task_.colour->at(x, y) = stored(c);
      else
        seams_of_row_[static_cast<size_t>(y)].push_back(seam_pixel(x, index, *side, c));
    }
  }

  void for_each_seam(const std::function<void(const SeamSample&)>& visit) const {
    for (int y = 0; y < grid_.height; ++y)
      for (const SeamPixel& p : seams_of_row_[static_cast<size_t>(y)]) {
        const Rgb c = task_.colour->at(p.x, y);
        const Colour step = {p.seen[0] - c.r * kColourSteps, p.seen[1] - c.g * kColourSteps,
                             p.seen[2] - c.b * kColourSteps};
        visit({p.x, y, task_.source->at(p.x, y), p.other, static_cast<uint8_t>(p.side), step});
      }
  }

 private:
  struct Span {
    int begin = 0, end = 0;
  };

  Voxel at(int x, int y) const {
    return {x, y, grid_.inverse_depth(task_.disparity->at(x, y)), task_.source->at(x, y),
            task_.neighbours ? task_.neighbours->at(x, y) : uint8_t{0}};
  }

  Span span_of(int index) const {
    return static_cast<size_t>(index) < spans_.size() ? spans_[static_cast<size_t>(index)] : Span{};
  }

  // The columns in which each photograph is taken, and one more on either side.
  void find_spans() {
    for (int y = 0; y < grid_.height; ++y)
      for (int x = 0; x < grid_.width; ++x) {
        if (task_.source->at(x, y) == kNoSource) continue;
        const auto source = static_cast<size_t>(task_.source->at(x, y));
        if (source >= spans_.size()) spans_.resize(source + 1, {grid_.width, 0});
        spans_[source].begin = std::min(spans_[source].begin, x);
        spans_[source].end = std::max(spans_[source].end, x + 1);
      }
    for (Span& span : spans_) {
      if (span.begin >= span.end) continue;
      const bool across = grid_.wraps && (span.begin == 0 || span.end == grid_.width);
      span = across ? Span{0, grid_.width} : Span{std::max(0, span.begin - 1), std::min(grid_.width, span.end + 1)};
    }
  }

  // On which side of a pixel (kSides) the same surface is taken from photograph `index`.
  std::optional<uint8_t> side_of(int x, int y, int index) const {
    const int d = task_.disparity->at(x, y);
    for (uint8_t side = 0; side < 4; ++side) {
      int nx = x + kSides[side][0];
      const int ny = y + kSides[side][1];
      if (grid_.wraps) nx = (nx + grid_.width) % grid_.width;
      if (!task_.disparity->contains(nx, ny) || task_.source->at(nx, ny) != index) continue;
      if (kOneSurface.same_surface(task_.disparity->at(nx, ny), d)) return side;
    }
    return {};
  }

  const PanoramaGrid& grid_;
  ColourTask task_;
  std::vector<Span> spans_;  // up to the last photograph that is taken
  std::vector<std::vector<SeamPixel>> seams_of_row_;
};

void compare_with_neighbours(const OpenPhotographs& open, const std::vector<LayerBlend>& layers, int index,
                             const Job& job, BrightnessDifferences& differences) {
  differences.clear();
  parallel_for(job, differences.rows(), [&](int row) {
    std::array<std::vector<Colour>, kNeighbourViews> samples;
    for (int column = 0; column < differences.columns(); ++column) {
      for (auto& of_neighbour : samples) of_neighbour.clear();
      for (const LayerBlend& layer : layers) layer.compare(open, differences, index, column, row, samples);
      for (int neighbour = 0; neighbour < kNeighbourViews; ++neighbour)
        differences.set(column, row, neighbour, samples[static_cast<size_t>(neighbour)]);
    }
  });
}

// Reads one photograph after another; what its own pixels show is taken when those beside it are there.
void read_photographs(const PanoramaGrid& grid, const Photographs& photographs, std::vector<LayerBlend>& layers,
                      const Job& job) {
  const int cameras = static_cast<int>(photographs.cameras.size());
  const int strips = (grid.height + kRowsAtOnce - 1) / kRowsAtOnce;
  OpenPhotographs open(grid, photographs);
  BrightnessDifferences differences(grid);
  for (int next = 0; next <= cameras + kViewsAside;
       ++next) {  // is read while colours are taken from what was read before
    job.report("colour", static_cast<double>(next) / (cameras + kViewsAside + 1));
    const int index = next - kViewsAside - 1;
    open.close(index - kViewsAside - 1);
    if (index >= 0) compare_with_neighbours(open, layers, index, job, differences);
    parallel_for(job, index >= 0 ? 1 + strips : 1, [&](int task) {
      if (task == 0) {
        if (next < cameras) open.load(next);
        return;
      }
      for (int y = (task - 1) * kRowsAtOnce; y < std::min(grid.height, task * kRowsAtOnce); ++y)
        for (LayerBlend& layer : layers) layer.blend_row(open, differences, index, y);
    });
  }
}

}  // namespace
}  // namespace ldp::colour

namespace ldp {

using namespace colour;

void blend_colours(const PanoramaGrid& grid, const Photographs& photographs, const std::vector<ColourTask>& tasks,
                   const ColourOptions& options, const Job& job) {
  std::vector<LayerBlend> layers;
  for (const ColourTask& task : tasks) layers.emplace_back(grid, task);
  read_photographs(grid, photographs, layers, job);
  if (!options.level_seams) return;
  const auto seams = [&](const std::function<void(const SeamSample&)>& visit) {
    for (const LayerBlend& layer : layers) layer.for_each_seam(visit);
  };
  level_seams(grid, tasks, seams, options, job);
}

}  // namespace ldp
