#include <algorithm>
#include <cmath>
#include <string>

#include "colour.h"
#include "photo_sampler.h"
#include "seams.h"

namespace ldp {
namespace {

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
  }

  void fetch_row(const PhotoSampler& sampler, const RgbImage& photo, uint8_t index, int y) {
    const uint8_t* source = task_.source->row(y);
    const uint16_t* disparity = task_.disparity->row(y);
    for (int x = 0; x < grid_.width; ++x) {
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
  std::vector<std::vector<SeamPixel>> seams_of_row_;
};

}  // namespace

void fetch_colours(const PanoramaGrid& grid, const Photographs& photographs, const std::vector<ColourTask>& tasks,
                   const ColourOptions& options, const Job& job) {
  std::vector<LayerFetch> layers;
  for (const ColourTask& task : tasks) layers.emplace_back(grid, task);
  const size_t cameras = photographs.cameras.size();
  for (size_t i = 0; i < cameras; ++i) {
    job.report("colour", static_cast<double>(i) / static_cast<double>(cameras));
    const RgbImage photo = photographs.frames.load(photographs.frame_of_camera[i]);
    const PhotoSampler sampler(grid, photographs.cameras[i], photographs.gains[i]);
    for (LayerFetch& layer : layers)
      parallel_for(job, grid.height, [&](int y) { layer.fetch_row(sampler, photo, static_cast<uint8_t>(i), y); });
  }
  if (!options.even_seams) return;
  std::vector<SeamSample> samples;
  for (const LayerFetch& layer : layers) layer.collect(samples);
  even_seams(grid, tasks, samples, options, job);
}

}  // namespace ldp
