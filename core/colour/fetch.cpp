#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "colour.h"
#include "photo_sampler.h"
#include "seams.h"

namespace ldp {
namespace {

constexpr int kRowsAtOnce = 16;
constexpr int kSameSurface = kDisparitySteps / (kLabels - 1);

// One pixel of a border, met while its neighbour's photograph is in memory.
struct SeamPixel {
  int x = 0, y = 0;
  uint8_t own = 0, other = 0;
  Colour seen{};
};

Rgb stored(const Colour& c) {
  const auto channel = [](int v) {
    return static_cast<uint8_t>(std::clamp((v + kColourSteps / 2) / kColourSteps, 0, 255));
  };
  return {channel(c[0]), channel(c[1]), channel(c[2])};
}

class LayerFetch {
 public:
  LayerFetch(const PanoramaGrid& grid, const ColourTask& task) : grid_(grid), task_(task) {
    seams_of_row_.resize(static_cast<size_t>(grid.height));
    find_spans();
  }

  void fetch_row(const PhotoSampler& sampler, const RgbImage& photo, uint8_t index, int y) {
    const uint8_t* source = task_.source->row(y);
    const uint16_t* disparity = task_.disparity->row(y);
    for (int x = spans_[index].begin; x < spans_[index].end; ++x) {
      if (source[x] == kNoSource) continue;
      const bool own = source[x] == index;
      if (!own && !borders(x, y, index)) continue;
      const Colour c = sampler.sample(photo, x, y, grid_.inverse_depth(disparity[x]));
      if (own)
        task_.colour->at(x, y) = stored(c);
      else
        seams_of_row_[static_cast<size_t>(y)].push_back({x, y, source[x], index, c});
    }
  }

  void collect(std::vector<SeamSample>& samples) const {
    for (const auto& row : seams_of_row_)
      for (const SeamPixel& p : row) {
        const Rgb c = task_.colour->at(p.x, p.y);
        SeamSample s{p.x, p.y, p.own, p.other, p.seen};
        s.step[0] -= c.r * kColourSteps, s.step[1] -= c.g * kColourSteps, s.step[2] -= c.b * kColourSteps;
        samples.push_back(s);
      }
  }

 private:
  struct Span {
    int begin = 0, end = 0;
  };

  // The columns in which each photograph is taken, and one more on either side.
  void find_spans() {
    spans_.fill({grid_.width, 0});
    for (int y = 0; y < grid_.height; ++y) {
      const uint8_t* source = task_.source->row(y);
      for (int x = 0; x < grid_.width; ++x) {
        Span& span = spans_[source[x]];
        span.begin = std::min(span.begin, x);
        span.end = std::max(span.end, x + 1);
      }
    }
    for (Span& span : spans_) {
      if (span.begin >= span.end) continue;
      const bool across = grid_.wraps && (span.begin == 0 || span.end == grid_.width);
      span = across ? Span{0, grid_.width} : Span{std::max(0, span.begin - 1), std::min(grid_.width, span.end + 1)};
    }
  }

  bool borders(int x, int y, uint8_t index) const {
    const int d = task_.disparity->at(x, y);
    const auto beside = [&](int nx, int ny) {
      if (grid_.wraps) nx = (nx + grid_.width) % grid_.width;
      if (!task_.source->contains(nx, ny) || task_.source->at(nx, ny) != index) return false;
      return std::abs(task_.disparity->at(nx, ny) - d) < kSameSurface;
    };
    return beside(x - 1, y) || beside(x + 1, y) || beside(x, y - 1) || beside(x, y + 1);
  }

  const PanoramaGrid& grid_;
  ColourTask task_;
  std::array<Span, 256> spans_;
  std::vector<std::vector<SeamPixel>> seams_of_row_;
};

}  // namespace

void fetch_colours(const PanoramaGrid& grid, const Photographs& photographs, const std::vector<ColourTask>& tasks,
                   const ColourOptions& options, const Job& job) {
  std::vector<LayerFetch> layers;
  for (const ColourTask& task : tasks) layers.emplace_back(grid, task);
  const size_t cameras = photographs.cameras.size();
  const int strips = (grid.height + kRowsAtOnce - 1) / kRowsAtOnce;
  RgbImage photo, next;
  for (size_t i = 0; i <= cameras; ++i) {  // reads photograph i while colours are taken from the one before
    job.report("colour", static_cast<double>(i) / static_cast<double>(cameras + 1));
    const auto index = static_cast<uint8_t>(i - 1);
    std::optional<PhotoSampler> sampler;
    if (i > 0) sampler.emplace(grid, photographs.cameras[i - 1], photographs.gains[i - 1]);
    parallel_for(job, i > 0 ? 1 + strips : 1, [&](int task) {
      if (task == 0) {
        if (i < cameras) next = photographs.frames.load(photographs.frame_of_camera[i]);
        return;
      }
      for (int y = (task - 1) * kRowsAtOnce; y < std::min(grid.height, task * kRowsAtOnce); ++y)
        for (LayerFetch& layer : layers) layer.fetch_row(*sampler, photo, index, y);
    });
    std::swap(photo, next);
  }
  if (!options.even_seams) return;
  std::vector<SeamSample> samples;
  for (const LayerFetch& layer : layers) layer.collect(samples);
  even_seams(grid, tasks, samples, options, job);
}

}  // namespace ldp
