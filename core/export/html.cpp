#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/export/export.h"
#include "core/export/surface.h"
#include "core/export/viewer_page.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

constexpr int kPartPx = 4095;  // with one column more, a texture that every graphics chip takes

std::string base64(const std::vector<uint8_t>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

int source_column(const LayeredPanorama& panorama, int x) {
  if (x < panorama.grid.width) return x;
  return panorama.grid.wraps ? x - panorama.grid.width : panorama.grid.width - 1;
}

// Red and green: disparity; blue: 0 where absent, else 1 + what one code means there.
RgbImage depth_part(const LayeredPanorama& panorama, const Layer& layer, int begin, int end) {
  RgbImage part(end - begin, panorama.grid.height);
  const DepthCodes& depth = layer.depth;
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) {
      const int from = source_column(panorama, begin + x);
      if (!layer.coverage.at(from, y)) continue;
      const int d = depth.disparity(from, y);
      const BlockRange range = depth.range(from, y);
      part.at(x, y) = {static_cast<uint8_t>(d >> 8), static_cast<uint8_t>(d & 255),
                       static_cast<uint8_t>(1 + std::min(254, range.high - range.low))};
    }
  return part;
}

RgbImage colour_part(const LayeredPanorama& panorama, const RgbImage& colour, int begin, int end) {
  RgbImage part(end - begin, colour.height);
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) part.at(x, y) = colour.at(source_column(panorama, begin + x), y);
  return part;
}

nlohmann::ordered_json parts_of(const LayeredPanorama& panorama, const ExportOptions& options, const Job& job) {
  nlohmann::ordered_json parts = nlohmann::ordered_json::array();
  for (const Layer& layer : panorama.layers) {
    job.check();
    const RgbImage colour = spread_colour(layer);
    for (int begin = 0; begin < panorama.grid.width; begin += kPartPx) {
      const bool ends = begin + kPartPx >= panorama.grid.width;
      const int end = ends ? panorama.grid.width + panorama.grid.wraps : begin + kPartPx + 1;
      parts.push_back(
          {{"x", begin},
           {"colour", "data:image/jpeg;base64," +
                          base64(encode_jpeg(colour_part(panorama, colour, begin, end), options.quality))},
           {"depth", "data:image/png;base64," + base64(encode_png(depth_part(panorama, layer, begin, end)))}});
    }
  }
  return parts;
}

}  // namespace

std::string export_html(const LayeredPanorama& panorama, const ExportOptions& options, const Job& job) {
  const PanoramaGrid& grid = panorama.grid;
  const nlohmann::ordered_json data = {{"width", grid.width},
                                       {"height", grid.height},
                                       {"thetaLeft", grid.theta_left},
                                       {"thetaPitch", grid.theta_pitch},
                                       {"vTop", grid.v_top},
                                       {"vPitch", grid.v_pitch},
                                       {"far", grid.w_far},
                                       {"near", grid.w_near},
                                       {"rays", grid.ray_radius()},
                                       {"radius", grid.arc.radius},
                                       {"inner", panorama.limits.inner_radius},
                                       {"outer", panorama.limits.outer_radius},
                                       {"rise", panorama.limits.height},
                                       {"steps", kDisparitySteps},
                                       {"slope", kSurfaceSlope},
                                       {"tolerance", kSurfaceTolerance},
                                       {"largestCell", kSurfaceLargestCell},
                                       {"parts", parts_of(panorama, options, job)}};
  std::string page = kViewerPage;
  const std::string mark = "@PANORAMA@";
  return page.replace(page.find(mark), mark.size(), data.dump());
}

}  // namespace ldp
