#include "core/view/mesh/code_smoother.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

class CodeSmoother {
 public:
  CodeSmoother(PreparedLayer& layer, const CodedDepths& depths, float parallax)
      : layer_(layer), depths_(depths), w_(layer.w), parallax_(parallax) {
    for (int y = 0; y < w_.height; ++y)
      for (int x = 0; x < w_.width; ++x)
        if (w_.at(x, y) >= 0 && depths.step(layer.step.at(x, y)) > kFineShare * parallax) add(x, y);
  }

  void run() {
    for (int i = 0; i < kSmoothings; ++i) {
      for (auto pixel = pixels_.begin(); pixel != pixels_.end(); ++pixel) relax(*pixel);
      for (auto pixel = pixels_.rbegin(); pixel != pixels_.rend(); ++pixel) relax(*pixel);
    }
  }

 private:
  struct Pixel {
    size_t index;
    float weight[4];  // of the left, right, upper and lower neighbour; they sum to 1
  };

  void add(int x, int y) {
    constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    Pixel pixel{w_.index(x, y), {}};
    float sum = 0;
    for (size_t k = 0; k < 4; ++k) {
      const int nx = x + kNeighbours[k][0], ny = y + kNeighbours[k][1];
      if (!w_.contains(nx, ny)) continue;
      const size_t n = w_.index(nx, ny);
      if (!connected(coded(pixel.index), step(pixel.index), coded(n), step(n), parallax_)) continue;
      pixel.weight[k] = 1 / (step(n) + 0.1F * parallax_);
      sum += pixel.weight[k];
    }
    if (sum <= 0) return;
    for (float& weight : pixel.weight) weight /= sum;
    pixels_.push_back(pixel);
  }

  void relax(const Pixel& pixel) {
    const std::ptrdiff_t offsets[4] = {-1, 1, -w_.width, w_.width};
    float mean = 0;
    for (size_t k = 0; k < 4; ++k)
      if (pixel.weight[k] > 0)
        mean +=
            pixel.weight[k] * w_.samples[static_cast<size_t>(static_cast<std::ptrdiff_t>(pixel.index) + offsets[k])];
    const float code = coded(pixel.index), half = 0.5F * step(pixel.index);
    w_.samples[pixel.index] = std::max(0.0F, std::clamp(mean, code - half, code + half));
  }

  float coded(size_t i) const { return depths_.w(layer_.code.samples[i]); }
  float step(size_t i) const { return depths_.step(layer_.step.samples[i]); }

  const PreparedLayer& layer_;
  const CodedDepths& depths_;
  Plane<float>& w_;
  float parallax_;
  std::vector<Pixel> pixels_;
};

}  // namespace

void smooth_codes(PreparedLayer& layer, const CodedDepths& depths, float parallax) {
  CodeSmoother(layer, depths, parallax).run();
}

}  // namespace ldp::view
