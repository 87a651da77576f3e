// Cameras as transforms.json, the convention of nerfstudio and gsplat tools: fl_x fl_y cx cy w h k1 k2 p1 p2 for all
// frames or per frame, and for each frame a file_path and a camera-to-world 4x4 transform_matrix in OpenGL axes (x
// right, y up, z back).
//
// Reading: camera_angle_x (radians) serves when fl_x is missing; fl_y defaults to fl_x, the principal point to the
// image's middle, distortion to 0. What a Camera cannot express (fisheye, k3, k4) is refused. Fields of no use here are
// skipped. Errors: std::runtime_error naming the file, the frame and the field.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/geometry.h"

namespace ldp {

std::vector<Camera> read_transforms(const std::filesystem::path& file);
std::vector<Camera> parse_transforms(std::string_view json, const std::string& name_for_errors);

// Intrinsics that all cameras share are written once; `software` tells who wrote them. Numbers are written so that
// reading gives the same doubles back, names as utf8 does (core/base/markup_text.h).
void write_transforms(const std::filesystem::path& file, std::span<const Camera> cameras);
std::string transforms_json(std::span<const Camera> cameras);

// The camera of a photo: of the same name, as it is or as it was written, else of the same name without the extension
// (transforms.json may leave it out, or the photo may have been converted). Null when there is none.
const Camera* find_camera(std::span<const Camera> cameras, std::string_view photo_name);

}  // namespace ldp
