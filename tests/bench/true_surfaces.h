// The surfaces that every ray of a panorama truly meets, for benchmarks.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "sim/scene/scene.h"

namespace ldp {

// A camera's picture and its true z-depth at the pixels' centres (infinity = sky).
struct TrueView {
  Camera camera;
  RgbImage colour;
  Plane<float> z;
};

// The views that a file of transforms in `folder` names: <folder>/<pictures>/*.png and <folder>/<pictures>_depth/*.npy
// (or .pfm).
std::vector<TrueView> read_true_views(const std::filesystem::path& folder, const std::string& transforms,
                                      const std::string& pictures);

// The scene that a folder's pictures show, where `ldp scene` made them (its capture.json tells): at rest, in full
// light.
std::optional<Scene> described_scene(const std::filesystem::path& folder);

struct TrueSurface {
  float w = -1;  // inverse depth; negative = none
  Rgb colour;
  uint8_t alpha = 255;  // share of the panorama's pixel that the surface covers
};
constexpr int kTrueLayers = 4;
using TrueSurfaces = std::array<TrueSurface, kTrueLayers>;  // along one ray, front to back

// Are two inverse depths of one ray two surfaces?
inline bool separate(float a, float b) { return std::abs(a - b) > 0.03F * std::max(a, b) + 0.004F; }

// Per panorama pixel, from photographs: what some of them sees, in their own colours (at outlines mixtures of two
// surfaces). Every surface covers its pixel whole.
std::vector<TrueSurfaces> surfaces_of_photos(const PanoramaGrid& grid, const std::vector<TrueView>& views);

// Per panorama pixel, traced through the scene: what some view sees, in colours without mixtures.
std::vector<TrueSurfaces> surfaces_of_scene(const PanoramaGrid& grid, const Scene& scene,
                                            const std::vector<TrueView>& views, const Job& job);

}  // namespace ldp
