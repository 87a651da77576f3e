// Meshes as small files: vertices and triangles put in the order in which neighbours follow each other, and coded as
// EXT_meshopt_compression has it (glTF). The one place that sees meshoptimizer.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/export/surface.h"

namespace ldp {

// The same surface: triangles in an order that coders and graphics chips like, vertices in the order in which they are
// used first.
Surface in_coding_order(const Surface& surface);

// Positions with a common exponent for each vertex and `bits` bits with sign of every coordinate, 4 bytes each: what is
// far is coarser as it may be (filter "EXPONENTIAL").
std::vector<uint32_t> share_exponents(std::span<const std::array<float, 3>> positions, int bits);
// What readers make of them.
std::vector<std::array<float, 3>> positions_of(std::span<const uint32_t> shared);

// Mode "ATTRIBUTES", `stride` bytes a vertex, a multiple of 4; mode "TRIANGLES".
std::vector<uint8_t> code_vertices(std::span<const uint8_t> bytes, size_t stride);
std::vector<uint8_t> code_triangles(std::span<const uint32_t> triangles, size_t vertices);

}  // namespace ldp
