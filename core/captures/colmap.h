// Cameras and points as a COLMAP text model (cameras.txt, images.txt, points3D.txt), which COLMAP, nerfstudio and
// gsplat tools read. COLMAP's world-to-camera rotations have our camera axes (x right, y down, z forward), its image
// positions our pixel centres at .5; its OPENCV camera model is our lens.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/geometry.h"

namespace ldp {

struct ColmapModel {
  std::span<const Camera> cameras;
  std::span<const ScenePoint> points;
  // Where the cameras of points[i] see it, pixels, in the order of points[i].cameras.
  std::span<const std::vector<Eigen::Vector2d>> sightings;
  std::span<const std::array<uint8_t, 3>> colours;  // of the points; none: grey
};

struct ColmapText {
  std::string cameras, images, points;
};

// Cameras of the same lens share one entry. Throws std::logic_error when the parts do not fit each other.
ColmapText colmap_text(const ColmapModel& model);

}  // namespace ldp
