#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "core/base/files.h"
#include "device/library/doors.h"
#include "device/library/panorama_handle.h"

struct ldp_writer {
  ldp::LayeredPanorama panorama;
};

namespace ldp::library {
namespace {

constexpr int kUsualQuality = 90;

void check_range(const char* field, int value, int least, int most) {
  if (value < least || value > most)
    throw Refusal(LDP_BAD_ARGUMENT, std::string(field) + " is " + std::to_string(value) + ", expected " +
                                        std::to_string(least) + " to " + std::to_string(most));
}

Arc arc_of(const ldp_description& told) {
  Arc arc;
  arc.centre = Eigen::Vector3d(told.arc_centre);
  arc.world_from_arc = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(told.world_from_arc);
  arc.radius = told.arc_radius;
  arc.theta_begin = told.theta_begin;
  arc.theta_end = told.theta_end;
  arc.closed = told.arc_closed != 0;
  return arc;
}

PanoramaGrid grid_of(const ldp_description& told) {
  check_range("width", told.width, 1, kMaxLdpWidth);
  check_range("height", told.height, 1, kMaxLdpHeight);
  if (int64_t{told.width} * told.height > kMaxLdpPixels)
    throw Refusal(LDP_BAD_ARGUMENT, "a grid has at most " + std::to_string(kMaxLdpPixels) + " pixels");
  check_range("rays", told.rays, LDP_RAYS_PUSHBROOM, LDP_RAYS_CENTRAL);
  PanoramaGrid grid;
  grid.arc = arc_of(told);
  grid.rays = told.rays == LDP_RAYS_CENTRAL ? Rays::central : Rays::pushbroom;
  grid.width = told.width, grid.height = told.height;
  grid.theta_left = told.theta_left, grid.theta_pitch = told.theta_pitch;
  grid.v_top = told.v_top, grid.v_pitch = told.v_pitch;
  grid.wraps = told.wraps != 0;
  grid.w_far = told.far_inverse_depth, grid.w_near = told.near_inverse_depth;
  return grid;
}

uint16_t disparity_at(const ldp_planes& planes, size_t at, const PanoramaGrid& grid) {
  if (planes.disparity != nullptr) {
    const uint16_t disparity = planes.disparity[at];
    if (disparity > LDP_MOST_DISPARITY && disparity != LDP_NO_DISPARITY)
      throw Refusal(LDP_BAD_ARGUMENT, "disparity " + std::to_string(disparity) + " is beyond 3825 and not 65535");
    return disparity;
  }
  const float depth = planes.depth[at];
  if (depth == 0) return kNoDisparity;
  if (!(depth > 0)) throw Refusal(LDP_BAD_ARGUMENT, "a depth is negative or not a number");
  if (!(grid.w_near > grid.w_far)) return 0;  // every disparity is the one depth that the grid has
  const double share = (1.0 / static_cast<double>(depth) - grid.w_far) / (grid.w_near - grid.w_far);
  return static_cast<uint16_t>(std::floor(std::clamp(share, 0.0, 1.0) * kDisparitySteps + 0.5));
}

Layer layer_of(const ldp_planes& planes, int block_px, const PanoramaGrid& grid) {
  const size_t row = static_cast<size_t>(planes.row_pixels > 0 ? planes.row_pixels : grid.width);
  DisparityMap map(grid.width, grid.height, kNoDisparity);
  Layer layer;
  layer.coverage = {grid.width, grid.height};
  layer.colour = {grid.width, grid.height};
  if (planes.alpha != nullptr) layer.alpha = {grid.width, grid.height};
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const size_t from = static_cast<size_t>(y) * row + static_cast<size_t>(x), to = map.index(x, y);
      map.samples[to] = disparity_at(planes, from, grid);
      if (map.samples[to] == kNoDisparity) continue;
      layer.coverage.samples[to] = 1;
      layer.colour.samples[to] = {planes.rgb[3 * from], planes.rgb[3 * from + 1], planes.rgb[3 * from + 2]};
      if (planes.alpha != nullptr) layer.alpha.samples[to] = planes.alpha[from];
    }
  layer.depth = encode_depth(map, block_px);
  return layer;
}

void add_layer(LayeredPanorama& panorama, const ldp_planes& planes, int block_px) {
  const PanoramaGrid& grid = panorama.grid;
  if (panorama.layers.size() == kMaxLdpLayers) throw Refusal(LDP_BAD_ARGUMENT, "there are 8 layers already");
  check_range("block_px", block_px, 0, kMaxLdpBlock);
  required(planes.rgb, "planes->rgb");
  if (planes.disparity == nullptr) required(planes.depth, "planes->disparity, and planes->depth too,");
  if (planes.begin != 0 || (planes.end != 0 && planes.end != grid.width))
    throw Refusal(LDP_BAD_ARGUMENT, "a layer is written whole: columns must be all or 0 to 0");
  if (planes.row_pixels != 0 && planes.row_pixels < grid.width)
    throw Refusal(LDP_BAD_ARGUMENT, "planes->row_pixels is less than the grid's width");
  panorama.layers.push_back(layer_of(planes, block_px, grid));
}

std::vector<uint8_t> encoded(const ldp_writer& writer, int colour_quality) {
  check_range("colour_quality", colour_quality, 0, 101);
  LdpEncodeOptions options;
  options.colour_quality = colour_quality == 0 ? kUsualQuality : colour_quality;
  try {
    return encode_ldp(writer.panorama, options);
  } catch (const LdpError& error) {  // what a reader would refuse is not written
    throw Refusal(LDP_BAD_ARGUMENT, error.what());
  } catch (const std::logic_error& error) {
    throw Refusal(LDP_BAD_ARGUMENT, error.what());
  }
}

}  // namespace
}  // namespace ldp::library

using namespace ldp::library;

ldp_status ldp_writer_new(const ldp_description* description, ldp_writer** writer, ldp_error* error) {
  return guarded("begin a file", error, [&] {
    const ldp_description told = taken(description, "description");
    required(writer, "writer");
    auto begun = std::make_unique<ldp_writer>();
    begun->panorama.grid = grid_of(told);
    begun->panorama.limits = {told.inner_radius, told.outer_radius, told.max_height};
    *writer = begun.release();
  });
}

ldp_status ldp_writer_from(const ldp_panorama* panorama, ldp_writer** writer, ldp_error* error) {
  return guarded("begin a file from a panorama", error, [&] {
    const ldp_panorama& file = required(panorama, "panorama");
    required(writer, "writer");
    check_memory(file, ldp::decoding_bytes(file.description(), 1), "decoding");
    auto begun = std::make_unique<ldp_writer>();
    begun->panorama = ldp::decode_ldp(file.bytes);
    *writer = begun.release();
  });
}

void ldp_writer_free(ldp_writer* writer) { delete writer; }

ldp_status ldp_writer_add_layer(ldp_writer* writer, const ldp_planes* planes, int block_px, ldp_error* error) {
  return guarded("add a layer", error,
                 [&] { add_layer(required(writer, "writer").panorama, taken(planes, "planes"), block_px); });
}

ldp_status ldp_writer_add_camera(ldp_writer* writer, const char* name, const ldp_camera* camera, ldp_error* error) {
  return guarded("add a camera", error, [&] {
    ldp::Camera added = camera_from(taken(camera, "camera"));
    added.name = &required(name, "name");
    required(writer, "writer").panorama.cameras.push_back(std::move(added));
  });
}

ldp_status ldp_writer_set_quality(ldp_writer* writer, const char* name, double value, ldp_error* error) {
  return guarded("set a figure of quality", error,
                 [&] { required(writer, "writer").panorama.quality[&required(name, "name")] = value; });
}

ldp_status ldp_writer_set_metadata(ldp_writer* writer, const char* name, const char* value, ldp_error* error) {
  return guarded("set an entry of metadata", error, [&] {
    required(writer, "writer").panorama.metadata[&required(name, "name")] = &required(value, "value");
  });
}

ldp_status ldp_writer_save(const ldp_writer* writer, const char* path, int colour_quality, ldp_error* error) {
  const auto attempted = [&] { return "write " + std::string(&required(path, "path")); };
  return guarded(attempted, error, [&] { ldp::write_file(path, encoded(required(writer, "writer"), colour_quality)); });
}

ldp_status ldp_writer_encode(const ldp_writer* writer, int colour_quality, void** bytes, size_t* count,
                             ldp_error* error) {
  return guarded("encode a file", error, [&] {
    required(bytes, "bytes"), required(count, "count");
    const std::vector<uint8_t> file = encoded(required(writer, "writer"), colour_quality);
    void* const copy = std::malloc(file.size());
    if (copy == nullptr) throw std::bad_alloc();
    std::memcpy(copy, file.data(), file.size());
    *bytes = copy, *count = file.size();
  });
}

void ldp_free(void* bytes) { std::free(bytes); }
