#include "core/export/mesh_codec.h"

#include <meshoptimizer.h>

#include <cstring>
#include <stdexcept>

namespace ldp {
namespace {

constexpr size_t kPositionBytes = 3 * sizeof(uint32_t);

std::vector<uint8_t> whole(std::vector<uint8_t> coded, size_t bytes) {
  if (bytes == 0) throw std::logic_error("meshoptimizer found too little room");
  coded.resize(bytes);
  return coded;
}

}  // namespace

Surface in_coding_order(const Surface& surface) {
  Surface ordered;
  ordered.triangles.resize(surface.triangles.size());
  const size_t indices = surface.triangles.size(), vertices = surface.vertices.size();
  meshopt_optimizeVertexCacheStrip(ordered.triangles.data(), surface.triangles.data(), indices, vertices);
  std::vector<uint32_t> place(vertices);
  const size_t used = meshopt_optimizeVertexFetchRemap(place.data(), ordered.triangles.data(), indices, vertices);
  ordered.vertices.resize(used);
  for (size_t i = 0; i < vertices; ++i)
    if (place[i] < used) ordered.vertices[place[i]] = surface.vertices[i];
  for (uint32_t& index : ordered.triangles) index = place[index];
  return ordered;
}

std::vector<uint32_t> share_exponents(std::span<const std::array<float, 3>> positions, int bits) {
  std::vector<uint32_t> shared(3 * positions.size());
  if (positions.empty()) return shared;
  meshopt_encodeFilterExp(shared.data(), positions.size(), kPositionBytes, bits, positions.front().data());
  return shared;
}

std::vector<std::array<float, 3>> positions_of(std::span<const uint32_t> shared) {
  std::vector<uint32_t> words(shared.begin(), shared.end());
  std::vector<std::array<float, 3>> positions(shared.size() / 3);
  if (positions.empty()) return positions;
  meshopt_decodeFilterExp(words.data(), positions.size(), kPositionBytes);
  std::memcpy(positions.data(), words.data(), words.size() * sizeof(uint32_t));
  return positions;
}

std::vector<uint8_t> code_vertices(std::span<const uint8_t> bytes, size_t stride) {
  const size_t count = bytes.size() / stride;
  meshopt_encodeVertexVersion(0);
  std::vector<uint8_t> coded(meshopt_encodeVertexBufferBound(count, stride));
  const size_t length = meshopt_encodeVertexBuffer(coded.data(), coded.size(), bytes.data(), count, stride);
  return whole(std::move(coded), length);
}

std::vector<uint8_t> code_triangles(std::span<const uint32_t> triangles, size_t vertices) {
  meshopt_encodeIndexVersion(1);
  std::vector<uint8_t> coded(meshopt_encodeIndexBufferBound(triangles.size(), vertices));
  const size_t length = meshopt_encodeIndexBuffer(coded.data(), coded.size(), triangles.data(), triangles.size());
  return whole(std::move(coded), length);
}

}  // namespace ldp
