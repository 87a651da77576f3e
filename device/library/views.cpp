#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "core/view/camera_path.h"
#include "core/view/framing.h"
#include "device/library/doors.h"
#include "device/library/panorama_handle.h"

namespace ldp::library {
namespace {

std::shared_ptr<Renderer> prepared(ldp_panorama& panorama, const Job& job) {
  const std::lock_guard lock(panorama.preparing);
  if (panorama.renderer) return panorama.renderer;
  const LdpDescription& file = panorama.description();
  check_memory(panorama, decoding_bytes(file, job.threads) + rendering_bytes(file), "preparing views");
  LayeredPanorama decoded = file.panorama;
  for (int i = 0; i < static_cast<int>(file.layers.size()); ++i)
    decoded.layers.push_back(panorama.reader.read_layer(i, job));
  job.check();
  panorama.renderer = std::make_shared<Renderer>(std::move(decoded));
  return panorama.renderer;
}

RenderOptions options_of(const ldp_view& view) {
  RenderOptions options;
  if (view.layers < 0) throw Refusal(LDP_BAD_ARGUMENT, "view->layers is negative");
  if (view.layers > 0) options.layers = view.layers;
  if (view.fill != LDP_FILL_NONE && view.fill != LDP_FILL_BACKGROUND)
    throw Refusal(LDP_BAD_ARGUMENT, "view->fill is " + std::to_string(view.fill) + ", expected 0 or 1");
  options.fill = view.fill == LDP_FILL_BACKGROUND ? Fill::background : Fill::none;
  options.depth = view.depth != nullptr;
  return options;
}

template <typename Sample>
void store(const Plane<Sample>& plane, void* target, size_t row_pixels) {
  if (target == nullptr) return;
  for (int y = 0; y < plane.height; ++y)
    std::memcpy(static_cast<uint8_t*>(target) + static_cast<size_t>(y) * row_pixels * sizeof(Sample), plane.row(y),
                static_cast<size_t>(plane.width) * sizeof(Sample));
}

void check_view(const ldp_panorama& panorama, const Camera& camera, const ldp_view& view) {
  const Intrinsics& k = camera.intrinsics;
  if (k.width < 1 || k.height < 1 || k.width > kMaxViewSide || k.height > kMaxViewSide)
    throw Refusal(LDP_BAD_ARGUMENT, "a view of " + std::to_string(k.width) + "x" + std::to_string(k.height) +
                                        " pixels; sides must be 1 to " + std::to_string(kMaxViewSide));
  if (view.row_pixels != 0 && view.row_pixels < k.width)
    throw Refusal(LDP_BAD_ARGUMENT, "view->row_pixels is less than the view's width");
  check_memory(panorama, kBytesOfView * static_cast<uint64_t>(k.width) * static_cast<uint64_t>(k.height), "the view");
}

void render(ldp_panorama& panorama, const Camera& camera, const ldp_view& view) {
  check_view(panorama, camera, view);
  const RenderOptions options = options_of(view);
  const Job job = job_of(view.threads, view.stop);
  const View rendered = prepared(panorama, job)->render(camera, options, job);
  const auto row_pixels = static_cast<size_t>(view.row_pixels > 0 ? view.row_pixels : camera.intrinsics.width);
  static_assert(sizeof(Rgb) == 3);
  store(rendered.colour, view.rgb, row_pixels);
  store(rendered.alpha, view.alpha, row_pixels);
  if (view.depth != nullptr) store(rendered.depth, view.depth, row_pixels);
}

void cameras_on_path(ldp_panorama& panorama, const CameraPathOptions& path, ldp_camera* cameras) {
  const Job job = job_of(0, nullptr);
  const std::shared_ptr<const Renderer> renderer = prepared(panorama, job);
  const LayeredPanorama& described = panorama.description().panorama;
  const size_t step = cameras->struct_bytes;
  auto* place = reinterpret_cast<unsigned char*>(cameras);
  for (const Camera& camera : camera_path(described, framed_inside(described, *renderer, path, job))) {
    ldp_camera told = camera_of(camera);
    told.struct_bytes = static_cast<uint32_t>(step);
    std::memcpy(place, &told, sizeof told);
    place += step;
  }
}

}  // namespace
}  // namespace ldp::library

using namespace ldp::library;

ldp_status ldp_prepare(ldp_panorama* panorama, int threads, ldp_stop* stop, ldp_error* error) {
  return guarded("prepare views", error, [&] {
    const ldp::Job job = job_of(threads, stop);
    prepared(required(panorama, "panorama"), job)->prepare(job);
  });
}

ldp_status ldp_render(ldp_panorama* panorama, const ldp_camera* camera, const ldp_view* view, ldp_error* error) {
  return guarded("render a view", error, [&] {
    render(required(panorama, "panorama"), camera_from(taken(camera, "camera")), taken(view, "view"));
  });
}

ldp_status ldp_cameras_on_path(ldp_panorama* panorama, const char* path, int frames, double fov_rad,
                               ldp_camera* cameras, ldp_error* error) {
  return guarded("lay a path of cameras", error, [&] {
    const ldp_camera first = taken(cameras, "cameras");
    const ldp::CameraPathOptions options{ldp::camera_path_from_name(&required(path, "path")), frames, first.width,
                                         first.height, fov_rad};
    cameras_on_path(required(panorama, "panorama"), options, cameras);
  });
}
