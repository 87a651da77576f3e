// True depth of a rendered capture, for benchmarks: NumPy depth maps of the frames, and the disparity that each
// panorama ray truly has.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"

namespace ldp {

// A two-dimensional little-endian float16 or float32 array in a .npy file.
Plane<float> read_npy(const std::filesystem::path& file);

// Where each ray first meets a surface that some of the cameras sees, as disparity; kNoDisparity where none does.
// depths[i] is the z-depth of cameras[i] (infinity = sky).
DisparityMap true_disparity(const PanoramaGrid& grid, const std::vector<Camera>& cameras,
                            const std::vector<Plane<float>>& depths, const Job& job);

}  // namespace ldp
