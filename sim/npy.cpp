#include "sim/npy.h"

#include <bit>
#include <string>

namespace ldp {

uint16_t half_from_float(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const uint32_t sign = (bits >> 16) & 0x8000, magnitude = bits & 0x7FFFFFFF;
  if (magnitude > 0x7F800000) return static_cast<uint16_t>(sign | 0x7E00);   // not a number
  if (magnitude >= 0x477FF000) return static_cast<uint16_t>(sign | 0x7C00);  // rounds beyond 65504
  if (magnitude < 0x33000001) return static_cast<uint16_t>(sign);            // rounds to nothing
  const uint32_t exponent = magnitude >> 23;
  uint32_t mantissa = magnitude & 0x7FFFFF, drop = 13, base = 0;
  if (exponent < 113) {  // a subnormal half
    mantissa |= 0x800000;
    drop = 126 - exponent;
  } else {
    base = (exponent - 112) << 10;
  }
  const uint32_t kept = mantissa >> drop, rest = mantissa & ((1U << drop) - 1), tie = 1U << (drop - 1);
  const uint32_t up = rest > tie || (rest == tie && (kept & 1) != 0) ? 1 : 0;
  return static_cast<uint16_t>(sign | (base + kept + up));
}

std::vector<uint8_t> encode_npy_half(const Plane<float>& values) {
  std::string header = "{'descr': '<f2', 'fortran_order': False, 'shape': (" + std::to_string(values.height) + ", " +
                       std::to_string(values.width) + "), }";
  header.resize((header.size() + 11 + 63) / 64 * 64 - 11, ' ');  // magic, version, length, text and newline fill 64s
  header += '\n';
  std::vector<uint8_t> bytes = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
  bytes.push_back(static_cast<uint8_t>(header.size() & 255));
  bytes.push_back(static_cast<uint8_t>(header.size() >> 8));
  bytes.insert(bytes.end(), header.begin(), header.end());
  bytes.reserve(bytes.size() + 2 * values.samples.size());
  for (const float value : values.samples) {
    const uint16_t half = half_from_float(value);
    bytes.push_back(static_cast<uint8_t>(half & 255));
    bytes.push_back(static_cast<uint8_t>(half >> 8));
  }
  return bytes;
}

}  // namespace ldp
