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
  uint8_t own = 0, other = 0, side = 0;
  Colour seen{};
};

Rgb stored(const Colour& c) {
  const auto channel = [](int v) {
    return static_cast<uint8_t>(std::clamp((v + kColourSteps / 2) / kColourSteps, 0, 255));
  };
  return {channel(c[0]), channel(c[1]), channel(c[2])};
}

// The photographs around the one that is taken from, in memory.
class OpenPhotographs {
 public:
  OpenPhotographs(const PanoramaGrid& grid, const Photographs& photographs)
      : grid_(grid), photographs_(photographs), open_(photographs.cameras.size()) {}

  void load(int index) {
    const auto i = static_cast<size_t>(index);
    open_[i].emplace(Open{photographs_.frames.load(photographs_.frame_of_camera[i]),
                          PhotoSampler(grid_, photographs_.cameras[i], photographs_.gains[i])});
  }
  void close(int index) {
    if (index >= 0) open_[static_cast<size_t>(index)].reset();
  }

  Colour sample(int index, int x, int y, double w) const {
    const Open& open = *open_[static_cast<size_t>(index)];
    return open.sampler.sample(open.picture, x, y, w);
  }

  // The mean of a sample of photograph `index` and of what those around it show there, where noise alone tells them
  // apart. (Another surface that looks the same does no harm.)
  Colour mean(const Colour& own, int index, int x, int y, double w) const {
    Colour sum = own;
    int count = 1;
    for (int other = std::max(0, index - reach()); other <= std::min(last(), index + reach()); ++other) {
      if (other == index) continue;
      const Open& open = *open_[static_cast<size_t>(other)];
      const std::optional<Colour> c = open.sampler.sample_if_inside(open.picture, x, y, w);
      if (!c || !is_noise(*c, own)) continue;
      for (size_t k = 0; k < sum.size(); ++k) sum[k] += (*c)[k];
      ++count;
    }
    for (int& channel : sum) channel = (channel + count / 2) / count;
    return sum;
  }

  int reach() const { return photographs_.noise_range > 0 ? kReach : 0; }

 private:
  struct Open {
    RgbImage picture;
    PhotoSampler sampler;
  };

  static constexpr int kReach = 2;  // photographs on either side that are averaged with one
  int last() const { return static_cast<int>(open_.size()) - 1; }

  bool is_noise(const Colour& a, const Colour& b) const {
    const int most = photographs_.noise_range * kColourSteps;
    return std::abs(a[0] - b[0]) <= most && std::abs(a[1] - b[1]) <= most && std::abs(a[2] - b[2]) <= most;
  }

  const PanoramaGrid& grid_;
  const Photographs& photographs_;
  std::vector<std::optional<Open>> open_;  // one per camera
};

class LayerFetch {
 public:
  LayerFetch(const PanoramaGrid& grid, const ColourTask& task) : grid_(grid), task_(task) {
    seams_of_row_.resize(static_cast<size_t>(grid.height));
    find_spans();
  }

  // What is taken from photograph `index`.
  void fetch_row(const OpenPhotographs& open, uint8_t index, int y) {
    const uint8_t* source = task_.source->row(y);
    const uint16_t* disparity = task_.disparity->row(y);
    for (int x = spans_[index].begin; x < spans_[index].end; ++x) {
      if (source[x] == kNoSource) continue;
      const bool own = source[x] == index;
      const auto side = own ? std::nullopt : side_of(x, y, index);
      if (!own && !side) continue;
      const double w = grid_.inverse_depth(disparity[x]);
      const Colour c = open.sample(index, x, y, w);
      if (own)
        task_.colour->at(x, y) = stored(open.mean(c, index, x, y, w));
      else
        seams_of_row_[static_cast<size_t>(y)].push_back({x, y, source[x], index, *side, c});
    }
  }

  void collect(std::vector<SeamSample>& samples) const {
    for (const auto& row : seams_of_row_)
      for (const SeamPixel& p : row) {
        const Rgb c = task_.colour->at(p.x, p.y);
        SeamSample s{p.x, p.y, p.own, p.other, p.side, p.seen};
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

  // On which side of a pixel (kSides) the same surface is taken from photograph `index`.
  std::optional<uint8_t> side_of(int x, int y, uint8_t index) const {
    const int d = task_.disparity->at(x, y);
    for (uint8_t side = 0; side < 4; ++side) {
      int nx = x + kSides[side][0];
      const int ny = y + kSides[side][1];
      if (grid_.wraps) nx = (nx + grid_.width) % grid_.width;
      if (!task_.source->contains(nx, ny) || task_.source->at(nx, ny) != index) continue;
      if (std::abs(task_.disparity->at(nx, ny) - d) < kSameSurface) return side;
    }
    return {};
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
  const int cameras = static_cast<int>(photographs.cameras.size());
  const int strips = (grid.height + kRowsAtOnce - 1) / kRowsAtOnce;
  OpenPhotographs open(grid, photographs);
  const int reach = open.reach();
  for (int next = 0; next <= cameras + reach; ++next) {  // is read while colours are taken from what was read before
    job.report("colour", static_cast<double>(next) / (cameras + reach + 1));
    const int index = next - reach - 1;
    open.close(index - reach - 1);
    parallel_for(job, index >= 0 ? 1 + strips : 1, [&](int task) {
      if (task == 0) {
        if (next < cameras) open.load(next);
        return;
      }
      for (int y = (task - 1) * kRowsAtOnce; y < std::min(grid.height, task * kRowsAtOnce); ++y)
        for (LayerFetch& layer : layers) layer.fetch_row(open, static_cast<uint8_t>(index), y);
    });
  }
  if (!options.even_seams) return;
  std::vector<SeamSample> samples;
  for (const LayerFetch& layer : layers) layer.collect(samples);
  even_seams(grid, tasks, samples, options, job);
}

}  // namespace ldp
