#include "core/base/files.h"
#include "core/captures/transforms.h"
#include "core/photos/images.h"
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

}  // namespace ldp
