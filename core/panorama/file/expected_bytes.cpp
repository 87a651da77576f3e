#include <algorithm>

#include "core/panorama/file/ldp_file.h"

namespace ldp {
namespace {

// Bytes a pixel of the picture that a strip's colours are stored in, and of the coefficients of a progressive one.
constexpr uint64_t kStoredColour = 3 + 6;

// Codes, coverage and colour of a pixel, and its alpha where there is any.
uint64_t bytes_a_pixel(const LdpLayerSummary& layer) { return 5 + (layer.has_alpha ? 1 : 0); }

struct StripSize {
  uint64_t pixels = 0, count = 0;
};

StripSize strips_of(const LdpLayerSummary& layer, const PanoramaGrid& grid) {
  const int width = std::min(layer.strip_px, grid.width);
  return {static_cast<uint64_t>(width) * static_cast<uint64_t>(grid.height),
          static_cast<uint64_t>((grid.width + width - 1) / width)};
}

}  // namespace

uint64_t decoding_bytes(const LdpDescription& description, int threads) {
  const PanoramaGrid& grid = description.panorama.grid;
  uint64_t layers = 0, in_work = 0;
  for (const LdpLayerSummary& layer : description.layers) {
    const StripSize strips = strips_of(layer, grid);
    const uint64_t at_once = std::min(strips.count, static_cast<uint64_t>(std::max(1, threads)));
    layers += static_cast<uint64_t>(grid.width) * static_cast<uint64_t>(grid.height) * bytes_a_pixel(layer);
    in_work = std::max(in_work, at_once * strips.pixels * (bytes_a_pixel(layer) + kStoredColour));
  }
  return layers + in_work;
}

uint64_t verifying_bytes(const LdpDescription& description) {
  uint64_t most = 0;
  for (const LdpLayerSummary& layer : description.layers)
    most = std::max(most, strips_of(layer, description.panorama.grid).pixels *
                              (2 * bytes_a_pixel(layer) + kStoredColour));  // as decoded, and in its place
  return most;
}

}  // namespace ldp
