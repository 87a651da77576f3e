#include "core/panorama/even_exposure.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/photos/exposure/response_curve.h"

namespace ldp {
namespace {

Rgb with_light(Rgb c, const std::array<double, 3>& factor, const ResponseCurve& response) {
  const std::array<int, 3> levels = ldp::with_light({c.r, c.g, c.b}, 1, factor, response);
  return {static_cast<uint8_t>(levels[0]), static_cast<uint8_t>(levels[1]), static_cast<uint8_t>(levels[2])};
}

}  // namespace

void even_out(LayeredPanorama& panorama, const Job& job) {
  if (panorama.exposure.empty()) return;
  const PanoramaGrid& grid = panorama.grid;
  const DisplayExposure exposure = std::exchange(panorama.exposure, {});
  parallel_for(job, grid.height, [&](int y) {
    for (int x = 0; x < grid.width; ++x) {
      std::array<double, 3> factor = exposure.factors.at((x + 0.5) / grid.width, (y + 0.5) / grid.height);
      for (double& f : factor) f = 1 / f;
      for (Layer& layer : panorama.layers) {
        Rgb& colour = layer.colour.at(x, y);
        colour = with_light(colour, factor, exposure.response);
      }
    }
  });
}

}  // namespace ldp
