// A view as an OpenEXR file, through libopenexr where the program was built with it.
//
// Channels R G B A Z. R G B: half floats, linear light in sRGB's primaries, multiplied with A, as the format's readers
// expect it. A: half, 0 .. 1. Z: floats, the samples of View::depth. Rows from top to bottom, compressed without loss.
#pragma once

#include <cstdint>
#include <vector>

#include "core/view/render.h"

namespace ldp {

// Bytes that making the file takes for each pixel of a view, beside the view: 12 at most in the file, and its growth.
constexpr uint64_t kBytesOfExr = 36;

// Throws BadInput where the program was built without OpenEXR.
void check_exr_is_built();

std::vector<uint8_t> encode_exr(const View& view);  // of a view with depth

}  // namespace ldp
