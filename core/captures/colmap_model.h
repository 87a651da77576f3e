// Cameras of a COLMAP model, text or binary, as COLMAP, hloc, GLOMAP and nerfstudio write it: a folder with cameras.txt
// and images.txt, or cameras.bin and images.bin, often called sparse/0. Points are not read.
//
// Camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV; any other is refused. Images are named by
// their last part. Errors: std::runtime_error naming the file, the place in it and what was found; every count is held
// against the file's size before anything is allocated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/geometry.h"

namespace ldp {

// The binary files where there are any, else the text ones. In the order of the images' names.
std::vector<Camera> read_colmap(const std::filesystem::path& folder);

std::vector<Camera> parse_colmap_text(std::string_view cameras, std::string_view images);
std::vector<Camera> parse_colmap_binary(std::span<const uint8_t> cameras, std::span<const uint8_t> images);

// A file as transforms.json, a folder as a COLMAP model.
std::vector<Camera> read_cameras(const std::filesystem::path& path);

}  // namespace ldp
