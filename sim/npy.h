// NumPy's .npy files of half-precision depths: version 1.0, "<f2", rows top to bottom.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/plane.h"

namespace ldp {

uint16_t half_from_float(float value);  // nearest, ties to even; too large becomes infinity
std::vector<uint8_t> encode_npy_half(const Plane<float>& values);

}  // namespace ldp
