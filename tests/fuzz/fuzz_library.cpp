// Any bytes through the C interface, checksums made right: described, read in part, rendered, written again. Whatever
// they are, a status comes back.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "device/library/ldp.h"
#include "tests/golden/sealed_file.h"

namespace {

constexpr int kWidth = 24, kHeight = 16;

void look(ldp_panorama* panorama, const ldp_description& told) {
  std::array<ldp_camera, 2> cameras{};
  cameras[0] = LDP_INIT(ldp_camera);
  cameras[0].width = kWidth, cameras[0].height = kHeight;
  if (told.cameras > 0) ldp_get_camera(panorama, told.cameras - 1, cameras.data(), nullptr, nullptr);
  if (cameras[0].width > 64 || cameras[0].height > 64 || told.cameras == 0) {
    cameras[0].width = kWidth, cameras[0].height = kHeight;
    if (ldp_cameras_on_path(panorama, "walk", 2, 0, cameras.data(), nullptr) != LDP_OK) return;
  }
  std::vector<uint8_t> rgb(3 * 64 * 64), alpha(64 * 64);
  std::vector<float> depth(64 * 64);
  ldp_view view = LDP_INIT(ldp_view);
  view.fill = LDP_FILL_BACKGROUND;
  view.rgb = rgb.data(), view.alpha = alpha.data(), view.depth = depth.data();
  ldp_render(panorama, cameras.data(), &view, nullptr);
}

void read(const ldp_panorama* panorama, const ldp_description& told) {
  const auto pixels = static_cast<size_t>(told.width) * static_cast<size_t>(told.height);
  std::vector<float> depth(pixels);
  std::vector<uint8_t> rgb(3 * pixels);
  ldp_planes planes = LDP_INIT(ldp_planes);
  planes.begin = told.width / 3, planes.end = told.width;
  planes.depth = depth.data(), planes.rgb = rgb.data();
  for (int layer = 0; layer < told.layers; ++layer) ldp_read_planes(panorama, layer, &planes, nullptr);
}

void write(const ldp_panorama* panorama) {
  ldp_writer* writer = nullptr;
  if (ldp_writer_from(panorama, &writer, nullptr) != LDP_OK) return;
  void* bytes = nullptr;
  size_t count = 0;
  if (ldp_writer_encode(writer, 60, &bytes, &count, nullptr) == LDP_OK) ldp_free(bytes);
  ldp_writer_free(writer);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::vector<uint8_t> file(data, data + size);
  ldp::seal(file);
  ldp_limits limits = LDP_INIT(ldp_limits);
  limits.pixels = 1 << 15;
  ldp_panorama* panorama = nullptr;
  ldp_error error{};
  if (ldp_open_memory(file.data(), file.size(), &limits, &panorama, &error) != LDP_OK) {
    if (error.status == LDP_INTERNAL) __builtin_trap();
    return 0;
  }
  ldp_description told = LDP_INIT(ldp_description);
  ldp_describe(panorama, &told, nullptr);
  ldp_verify(panorama, nullptr, nullptr);
  read(panorama, told);
  look(panorama, told);
  write(panorama);
  ldp_close(panorama);
  return 0;
}
