#include <Eigen/Core>
#include <iterator>
#include <string>

#include "core/captures/opengl_pose.h"
#include "device/library/doors.h"
#include "device/library/panorama_handle.h"

namespace ldp::library {
namespace {

using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

void describe_arc(const Arc& arc, ldp_description& told) {
  Eigen::Map<Eigen::Vector3d>(told.arc_centre) = arc.centre;
  Eigen::Map<RowMajor3>(told.world_from_arc) = arc.world_from_arc;
  told.arc_radius = arc.radius;
  told.theta_begin = arc.theta_begin;
  told.theta_end = arc.theta_end;
  told.arc_closed = arc.closed ? 1 : 0;
}

void describe_grid(const PanoramaGrid& grid, ldp_description& told) {
  told.width = grid.width;
  told.height = grid.height;
  told.rays = grid.rays == Rays::central ? LDP_RAYS_CENTRAL : LDP_RAYS_PUSHBROOM;
  told.wraps = grid.wraps ? 1 : 0;
  told.theta_left = grid.theta_left;
  told.theta_pitch = grid.theta_pitch;
  told.v_top = grid.v_top;
  told.v_pitch = grid.v_pitch;
  told.far_inverse_depth = grid.w_far;
  told.near_inverse_depth = grid.w_near;
}

ldp_description description_of(const LdpDescription& file) {
  ldp_description told = LDP_INIT(ldp_description);
  const LayeredPanorama& panorama = file.panorama;
  told.format_version = file.version;
  told.file_bytes = file.file_bytes;
  told.layers = static_cast<int>(file.layers.size());
  told.cameras = static_cast<int>(panorama.cameras.size());
  told.quality_figures = static_cast<int>(panorama.quality.size());
  told.metadata_entries = static_cast<int>(panorama.metadata.size());
  describe_grid(panorama.grid, told);
  describe_arc(panorama.grid.arc, told);
  told.inner_radius = panorama.limits.inner_radius;
  told.outer_radius = panorama.limits.outer_radius;
  told.max_height = panorama.limits.height;
  return told;
}

template <typename Map>
const auto& entry(const Map& map, const char* what, int index) {
  check_index(what, index, map.size());
  return *std::next(map.begin(), index);
}

}  // namespace

ldp_camera camera_of(const Camera& camera) {
  ldp_camera told = LDP_INIT(ldp_camera);
  const Intrinsics& k = camera.intrinsics;
  told.width = k.width, told.height = k.height;
  told.fl_x = k.fx, told.fl_y = k.fy, told.cx = k.cx, told.cy = k.cy;
  told.k1 = k.k1, told.k2 = k.k2, told.p1 = k.p1, told.p2 = k.p2;
  Eigen::Map<RowMajor4>(told.world_from_camera) = opengl_matrix(camera.pose);
  return told;
}

Camera camera_from(const ldp_camera& given) {
  Camera camera;
  camera.intrinsics = {given.width, given.height, given.fl_x, given.fl_y, given.cx,
                       given.cy,    given.k1,     given.k2,   given.p1,   given.p2};
  for (const double value : {given.fl_x, given.fl_y, given.cx, given.cy, given.k1, given.k2, given.p1, given.p2})
    if (!std::isfinite(value)) throw Refusal(LDP_BAD_ARGUMENT, "camera: has a number that is not finite");
  const Eigen::Map<const RowMajor4> matrix(given.world_from_camera);
  if (!matrix.row(3).head<3>().isZero(0))
    throw Refusal(LDP_BAD_ARGUMENT, "camera->world_from_camera has a last row other than 0 0 0 1: is it transposed?");
  const auto pose = pose_of_opengl(matrix);
  if (!pose)
    throw Refusal(LDP_BAD_ARGUMENT,
                  "camera->world_from_camera is not a rotation and a position (its columns must be unit, orthogonal "
                  "and right-handed)");
  camera.pose = *pose;
  return camera;
}

}  // namespace ldp::library

using namespace ldp::library;

ldp_status ldp_describe(const ldp_panorama* panorama, ldp_description* description, ldp_error* error) {
  return guarded("describe a panorama", error, [&] {
    check_result(description, "description");
    give(description_of(required(panorama, "panorama").description()), *description);
  });
}

ldp_status ldp_describe_layer(const ldp_panorama* panorama, int layer, ldp_layer_description* description,
                              ldp_error* error) {
  return guarded("describe a layer", error, [&] {
    check_result(description, "description");
    const auto& layers = required(panorama, "panorama").description().layers;
    check_index("layer", layer, layers.size());
    const ldp::LdpLayerSummary& summary = layers[static_cast<size_t>(layer)];
    ldp_layer_description told = LDP_INIT(ldp_layer_description);
    told.block_px = summary.block_px;
    told.has_alpha = summary.has_alpha ? 1 : 0;
    told.present_pixels = summary.present_pixels;
    give(told, *description);
  });
}

ldp_status ldp_get_camera(const ldp_panorama* panorama, int index, ldp_camera* camera, const char** name,
                          ldp_error* error) {
  return guarded("get a camera", error, [&] {
    const auto& cameras = required(panorama, "panorama").description().panorama.cameras;
    check_index("camera", index, cameras.size());
    const ldp::Camera& source = cameras[static_cast<size_t>(index)];
    if (camera != nullptr) {
      check_result(camera, "camera");
      give(camera_of(source), *camera);
    }
    if (name != nullptr) *name = source.name.c_str();
  });
}

ldp_status ldp_get_quality(const ldp_panorama* panorama, int index, const char** name, double* value,
                           ldp_error* error) {
  return guarded("get a figure of quality", error, [&] {
    const auto& found = entry(required(panorama, "panorama").description().panorama.quality, "figure", index);
    if (name != nullptr) *name = found.first.c_str();
    if (value != nullptr) *value = found.second;
  });
}

ldp_status ldp_get_metadata(const ldp_panorama* panorama, int index, const char** name, const char** value,
                            ldp_error* error) {
  return guarded("get an entry of metadata", error, [&] {
    const auto& found = entry(required(panorama, "panorama").description().panorama.metadata, "entry", index);
    if (name != nullptr) *name = found.first.c_str();
    if (value != nullptr) *value = found.second.c_str();
  });
}

ldp_status ldp_get_thumbnail(const ldp_panorama* panorama, const uint8_t** bytes, size_t* count, ldp_error* error) {
  return guarded("get the thumbnail", error, [&] {
    const auto& thumbnail = required(panorama, "panorama").description().thumbnail;
    required(bytes, "bytes") = thumbnail.data();
    required(count, "count") = thumbnail.size();
  });
}

ldp_status ldp_verify(const ldp_panorama* panorama, ldp_stop* stop, ldp_error* error) {
  return guarded("verify a panorama", error, [&] {
    const ldp_panorama& file = required(panorama, "panorama");
    check_memory(file, ldp::verifying_bytes(file.description()), "verifying");
    const auto damages = ldp::verify_ldp(file.bytes, job_of(1, stop));
    if (!damages.empty()) throw Refusal(LDP_DAMAGED, damages.front() + (damages.size() > 1 ? " (and more)" : ""));
  });
}
