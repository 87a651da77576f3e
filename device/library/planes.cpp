#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "device/library/doors.h"
#include "device/library/panorama_handle.h"

namespace ldp::library {
namespace {

// Where the part's first pixel is in what was decoded, which begins at a block.
struct Part {
  int offset = 0, width = 0, height = 0;
  int64_t row_pixels = 0;
};

// Calls put(pixel of the layer, pixel of the caller's plane) for all of the part.
template <typename Put>
void for_each_pixel(const Part& part, const Layer& layer, const Put& put) {
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x)
      put(layer.coverage.index(part.offset + x, y), static_cast<size_t>(y * part.row_pixels + x));
}

void store_depth(const Part& part, const Layer& layer, const PanoramaGrid& grid, const ldp_planes& planes) {
  const DisparityMap map = decode_depth(layer.depth, layer.coverage);
  for_each_pixel(part, layer, [&](size_t from, size_t to) {
    const uint16_t disparity = map.samples[from];
    if (planes.disparity != nullptr) planes.disparity[to] = disparity;
    if (planes.depth == nullptr) return;
    // By plain division: 1 / 0 is infinity.
    planes.depth[to] = disparity == kNoDisparity ? 0 : static_cast<float>(1 / grid.inverse_depth(disparity));
  });
}

void store_bytes(const Part& part, const Layer& layer, const ldp_planes& planes) {
  for_each_pixel(part, layer, [&](size_t from, size_t to) {
    const uint8_t present = layer.coverage.samples[from];
    const uint8_t opacity = layer.alpha.empty() ? uint8_t{255} : layer.alpha.samples[from];
    if (planes.coverage != nullptr) planes.coverage[to] = present;
    if (planes.alpha != nullptr) planes.alpha[to] = present ? opacity : uint8_t{0};
    if (planes.rgb == nullptr) return;
    const Rgb colour = layer.colour.samples[from];
    planes.rgb[3 * to] = colour.r, planes.rgb[3 * to + 1] = colour.g, planes.rgb[3 * to + 2] = colour.b;
  });
}

LdpColumns columns_of(const ldp_planes& planes, int width) {
  if (planes.begin == 0 && planes.end == 0) return {0, width};
  if (planes.begin < 0 || planes.begin >= planes.end || planes.end > width)
    throw Refusal(LDP_BAD_ARGUMENT, "columns " + std::to_string(planes.begin) + " to " + std::to_string(planes.end) +
                                        " are not within the grid's " + std::to_string(width));
  return {planes.begin, planes.end};
}

// What is decoded of it, the disparities, and strips in work.
uint64_t reading_bytes(const LdpDescription& file, size_t layer, const LdpColumns& columns, int threads) {
  constexpr uint64_t kOfPart = 8, kOfStrip = 6 + 9;  // bytes a pixel
  const auto height = static_cast<uint64_t>(file.panorama.grid.height);
  const auto width = static_cast<uint64_t>(columns.end - columns.begin);
  const auto strip = static_cast<uint64_t>(std::min(file.layers[layer].strip_px, file.panorama.grid.width));
  const uint64_t at_once = std::min(static_cast<uint64_t>(threads), width / strip + 2);
  return height * (kOfPart * width + kOfStrip * strip * at_once);
}

void read_planes(const ldp_panorama& panorama, int number, const ldp_planes& planes) {
  const LdpDescription& file = panorama.description();
  check_index("layer", number, file.layers.size());
  const auto layer_index = static_cast<size_t>(number);
  const LdpColumns columns = columns_of(planes, file.panorama.grid.width);
  const int width = columns.end - columns.begin;
  if (planes.row_pixels != 0 && planes.row_pixels < width)
    throw Refusal(LDP_BAD_ARGUMENT,
                  "row_pixels is " + std::to_string(planes.row_pixels) + ", a row has " + std::to_string(width));
  const Job job = job_of(planes.threads, planes.stop);
  check_memory(panorama, reading_bytes(file, layer_index, columns, job.threads), "reading");
  const int block_px = std::max(1, file.layers[layer_index].block_px);
  const LdpColumns decoded{columns.begin / block_px * block_px, columns.end};
  const Layer layer = panorama.reader.read_layer(number, decoded, planes.rgb != nullptr, job);
  const Part part{columns.begin - decoded.begin, width, file.panorama.grid.height,
                  planes.row_pixels == 0 ? width : planes.row_pixels};
  if (planes.depth != nullptr || planes.disparity != nullptr) store_depth(part, layer, file.panorama.grid, planes);
  if (planes.coverage != nullptr || planes.alpha != nullptr || planes.rgb != nullptr) store_bytes(part, layer, planes);
}

}  // namespace
}  // namespace ldp::library

using namespace ldp::library;

ldp_status ldp_read_planes(const ldp_panorama* panorama, int layer, const ldp_planes* planes, ldp_error* error) {
  const auto attempted = [&] { return "read layer " + std::to_string(layer); };
  return guarded(attempted, error,
                 [&] { read_planes(required(panorama, "panorama"), layer, taken(planes, "planes")); });
}
