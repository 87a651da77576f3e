#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/captures/transforms.h"
#include "core/photos/images.h"
#include "sim/scene/scenes.h"
#include "tests/bench/depth_truth.h"
#include "tests/bench/true_surfaces.h"

namespace ldp {

std::vector<TrueView> read_true_views(const std::filesystem::path& folder, const std::string& transforms,
                                      const std::string& pictures) {
  namespace fs = std::filesystem;
  std::vector<TrueView> views;
  for (const Camera& camera : read_transforms(folder / transforms)) {
    fs::path depth = folder / (pictures + "_depth") / fs::path(camera.name).stem();
    TrueView view{camera, read_image(folder / pictures / camera.name), {}};
    if (fs::exists(depth.replace_extension(".npy")))
      view.z = read_npy(depth);
    else
      view.z = decode_pfm(read_file(depth.replace_extension(".pfm")), depth.string());
    views.push_back(std::move(view));
  }
  return views;
}

std::optional<Scene> described_scene(const std::filesystem::path& folder) {
  std::ifstream in(folder / "capture.json");
  if (!in) return {};
  const std::string camera = nlohmann::json::parse(in).value("camera", "");
  char name[64];
  unsigned seed = 0;
  if (std::sscanf(camera.c_str(), "scene:%63[^?]?seed=%u", name, &seed) != 2) return {};
  return Scene(make_scene(name, seed));
}

}  // namespace ldp
