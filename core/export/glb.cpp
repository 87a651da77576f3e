#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/captures/json_text.h"
#include "core/export/export.h"
#include "core/export/mesh_codec.h"
#include "core/export/surface.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kTexturePx = 4096;  // columns of one texture: what every graphics chip takes
// Disparity steps by which surfaces may be flatter than depths: .3 to 1.2 % of the inverse-depth range.
constexpr std::array kTolerances = {kSurfaceTolerance, 17, 24, 34, 4 * kSurfaceTolerance};
constexpr double kHorizon = 1000.0;  // points at infinity are drawn at this many times the arc's radius (or unit, if 0)
// Of a coordinate, sign and all, where exponents are shared: a third of a pixel of a panorama of 3000 px at most.
constexpr int kPositionBits = 13;
constexpr int kWebpLessQuality = 10;  // than JPEG, for pictures of about the same faults
constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kWebp = "EXT_texture_webp";
constexpr int kArrayBuffer = 34962, kIndexBuffer = 34963;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

class GlbWriter {
 public:
  GlbWriter(const LayeredPanorama& panorama, const ExportOptions& options, const Job& job)
      : panorama_(panorama), options_(options), job_(job) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "layered-depth-panorama"}};
    json_["extensionsUsed"] = Json::array({"KHR_materials_unlit"});
    if (!options.plain) {
      json_["extensionsUsed"] = Json::array({"KHR_materials_unlit", kMeshopt, kWebp});
      json_["extensionsRequired"] = Json::array({kMeshopt, kWebp});
    }
    json_["scene"] = 0;
    json_["scenes"] = Json::array({Json{{"nodes", Json::array()}}});
    json_["samplers"] =
        Json::array({Json{{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 33071}, {"wrapT", 33071}}});
    for (const char* list : {"nodes", "meshes", "materials", "textures", "images", "accessors", "bufferViews"})
      json_[list] = Json::array();
  }

  void add_layer(size_t index, SurfacePart part) {
    const RgbImage colour = spread_colour(panorama_.layers[index]);
    Json primitives = Json::array();
    for (int begin = 0; begin < panorama_.grid.width; begin += kTexturePx) {
      part.begin = begin;
      part.end = std::min(panorama_.grid.width, begin + kTexturePx);
      const Surface surface = make_surface(panorama_, index, part, job_);
      if (!surface.triangles.empty()) primitives.push_back(add_part(surface, colour, begin, part.end));
    }
    if (primitives.empty()) return;
    const std::string name = "layer " + std::to_string(index + 1);
    json_["scenes"][0]["nodes"].push_back(json_["nodes"].size());
    json_["nodes"].push_back({{"name", name}, {"mesh", json_["meshes"].size()}});
    json_["meshes"].push_back({{"name", name}, {"primitives", primitives}});
  }

  std::vector<uint8_t> finish() {
    if (json_["meshes"].empty())
      for (const char* list : {"nodes", "meshes", "materials", "textures", "images", "accessors", "bufferViews",
                               "samplers", "extensionsUsed", "extensionsRequired"})
        json_.erase(list);
    if (!binary_.empty()) json_["buffers"] = Json::array({Json{{"byteLength", binary_.size()}}});
    if (unpacked_ > 0)  // never there: where readers put what they unpack
      json_["buffers"].push_back({{"byteLength", unpacked_}, {"extensions", {{kMeshopt, {{"fallback", true}}}}}});
    if (json_["scenes"][0]["nodes"].empty()) json_["scenes"][0].erase("nodes");
    std::string text = json_text(json_);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<uint8_t> out;
    const size_t binary_chunk = binary_.empty() ? 0 : 8 + binary_.size();
    put_u32(out, 0x46546C67), put_u32(out, 2), put_u32(out, static_cast<uint32_t>(12 + 8 + text.size() + binary_chunk));
    put_u32(out, static_cast<uint32_t>(text.size())), put_u32(out, 0x4E4F534A);
    out.insert(out.end(), text.begin(), text.end());
    if (binary_chunk == 0) return out;
    put_u32(out, static_cast<uint32_t>(binary_.size())), put_u32(out, 0x004E4942);
    out.insert(out.end(), binary_.begin(), binary_.end());
    return out;
  }

 private:
  static void put_u32(std::vector<uint8_t>& out, uint32_t v) {
    for (int i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(v >> (8 * i) & 255));
  }

  size_t add_view(size_t begin, int target) {
    Json view{{"buffer", 0}, {"byteOffset", begin}, {"byteLength", binary_.size() - begin}};
    if (target != 0) view["target"] = target;
    json_["bufferViews"].push_back(view);
    binary_.resize((binary_.size() + 3) / 4 * 4);
    return json_["bufferViews"].size() - 1;
  }

  size_t add_accessor(const Json& accessor) {
    json_["accessors"].push_back(accessor);
    return json_["accessors"].size() - 1;
  }

  // In the arc's axes with y up: x = u(0), y = n, z = -u(90 degrees).
  std::array<float, 3> position(const SurfaceVertex& vertex) const {
    const PanoramaGrid& grid = panorama_.grid;
    const double unit = grid.arc.radius > 0 ? grid.arc.radius : 1.0;
    const double w = std::max(grid.inverse_depth(vertex.disparity), 1 / (kHorizon * unit));
    const double depth = 1 / w;
    const double theta = grid.theta(vertex.x_px);
    const double horizontal = grid.ray_radius() + depth;
    return {static_cast<float>(horizontal * std::cos(theta)), static_cast<float>(depth * grid.v(vertex.y_px)),
            static_cast<float>(-horizontal * std::sin(theta))};
  }

  // What vertices or triangles are coded to. `packing`: mode, count, byteStride and filter.
  size_t add_packed_view(const std::vector<uint8_t>& coded, Json packing, int target) {
    const size_t begin = binary_.size(), stride = packing["byteStride"],
                 bytes = stride * packing["count"].get<size_t>();
    binary_.insert(binary_.end(), coded.begin(), coded.end());
    binary_.resize((binary_.size() + 3) / 4 * 4);
    packing.update(Json{{"buffer", 0}, {"byteOffset", begin}, {"byteLength", coded.size()}});
    Json view{{"buffer", 1}, {"byteOffset", unpacked_}, {"byteLength", bytes}, {"target", target}};
    if (target == kArrayBuffer) view["byteStride"] = stride;
    view["extensions"] = {{kMeshopt, packing}};
    unpacked_ += (bytes + 3) / 4 * 4;
    json_["bufferViews"].push_back(view);
    return json_["bufferViews"].size() - 1;
  }

  size_t add_vertex_view(const std::vector<uint8_t>& bytes, size_t count, const char* filter) {
    const size_t begin = binary_.size(), stride = bytes.size() / count;
    Json packing{{"byteStride", stride}, {"mode", "ATTRIBUTES"}, {"count", count}};
    if (filter != nullptr) packing["filter"] = filter;
    if (!options_.plain) return add_packed_view(code_vertices(bytes, stride), packing, kArrayBuffer);
    binary_.insert(binary_.end(), bytes.begin(), bytes.end());
    return add_view(begin, kArrayBuffer);
  }

  size_t add_positions(const Surface& surface) {
    std::vector<std::array<float, 3>> positions;
    for (const SurfaceVertex& vertex : surface.vertices) positions.push_back(position(vertex));
    std::vector<uint8_t> bytes;
    if (options_.plain) {
      for (const std::array<float, 3>& p : positions)
        for (const float v : p) put_u32(bytes, std::bit_cast<uint32_t>(v));
    } else {
      const std::vector<uint32_t> shared = share_exponents(positions, kPositionBits);
      for (const uint32_t word : shared) put_u32(bytes, word);
      positions = positions_of(shared);
    }
    std::array<float, 3> least = positions.front(), most = positions.front();
    for (const std::array<float, 3>& p : positions)
      for (size_t i = 0; i < 3; ++i) least[i] = std::min(least[i], p[i]), most[i] = std::max(most[i], p[i]);
    return add_accessor({{"bufferView", add_vertex_view(bytes, positions.size(), "EXPONENTIAL")},
                         {"componentType", kFloat},
                         {"count", positions.size()},
                         {"type", "VEC3"},
                         {"min", least},
                         {"max", most}});
  }

  size_t add_texture_places(const Surface& surface, int begin_px, int width) {
    std::vector<uint8_t> bytes;
    const auto put = [&](double share) {
      const auto v = static_cast<uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * 65535));
      bytes.push_back(static_cast<uint8_t>(v & 255));
      bytes.push_back(static_cast<uint8_t>(v >> 8));
    };
    for (const SurfaceVertex& vertex : surface.vertices) {
      put((double{vertex.u_px} - begin_px) / width);
      put(double{vertex.v_px} / panorama_.grid.height);
    }
    return add_accessor({{"bufferView", add_vertex_view(bytes, surface.vertices.size(), nullptr)},
                         {"componentType", kUnsignedShort},
                         {"normalized", true},
                         {"count", surface.vertices.size()},
                         {"type", "VEC2"}});
  }

  size_t add_triangle_view(const Surface& surface) {
    const size_t begin = binary_.size();
    if (!options_.plain)
      return add_packed_view(code_triangles(surface.triangles, surface.vertices.size()),
                             {{"byteStride", 4}, {"mode", "TRIANGLES"}, {"count", surface.triangles.size()}},
                             kIndexBuffer);
    for (const uint32_t index : surface.triangles) put_u32(binary_, index);
    return add_view(begin, kIndexBuffer);
  }

  size_t add_indices(const Surface& surface) {
    return add_accessor({{"bufferView", add_triangle_view(surface)},
                         {"componentType", kUnsignedInt},
                         {"count", surface.triangles.size()},
                         {"type", "SCALAR"}});
  }

  Json texture_of(const RgbImage& image) {
    const size_t at = binary_.size();
    const std::vector<uint8_t> coded = options_.plain
                                           ? encode_jpeg(image, options_.quality)
                                           : encode_webp(image, std::max(1, options_.quality - kWebpLessQuality));
    binary_.insert(binary_.end(), coded.begin(), coded.end());
    const char* const type = options_.plain ? "image/jpeg" : "image/webp";
    json_["images"].push_back({{"bufferView", add_view(at, 0)}, {"mimeType", type}});
    const size_t source = json_["images"].size() - 1;
    if (options_.plain) return {{"sampler", 0}, {"source", source}};
    return {{"sampler", 0}, {"extensions", {{kWebp, {{"source", source}}}}}};
  }

  // One column more than the part, for the quads that lead to the next one.
  size_t add_material(const RgbImage& colour, int begin, int end) {
    RgbImage part(end - begin + 1, colour.height);
    for (int y = 0; y < part.height; ++y)
      for (int x = 0; x < part.width; ++x) {
        const int from = begin + x < colour.width ? begin + x : panorama_.grid.wraps ? 0 : colour.width - 1;
        part.at(x, y) = colour.at(from, y);
      }
    json_["textures"].push_back(texture_of(part));
    json_["materials"].push_back({{"pbrMetallicRoughness",
                                   {{"baseColorTexture", {{"index", json_["textures"].size() - 1}}},
                                    {"metallicFactor", 0},
                                    {"roughnessFactor", 1}}},
                                  {"doubleSided", true},
                                  {"extensions", {{"KHR_materials_unlit", Json::object()}}}});
    return json_["materials"].size() - 1;
  }

  Json add_part(const Surface& unordered, const RgbImage& colour, int begin, int end) {
    const Surface surface = options_.plain ? unordered : in_coding_order(unordered);
    const size_t positions = add_positions(surface);
    const size_t places = add_texture_places(surface, begin, end - begin + 1);
    const size_t indices = add_indices(surface);
    const size_t material = add_material(colour, begin, end);
    return {{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", places}}},
            {"indices", indices},
            {"material", material}};
  }

  const LayeredPanorama& panorama_;
  const ExportOptions& options_;
  const Job& job_;
  Json json_;
  std::vector<uint8_t> binary_;
  size_t unpacked_ = 0;  // bytes of all that is coded, when it is not
};

size_t triangle_count(const LayeredPanorama& panorama, const SurfacePart& whole, const Job& job) {
  size_t count = 0;
  for (size_t layer = 0; layer < panorama.layers.size(); ++layer)
    count += make_surface(panorama, layer, whole, job).triangles.size() / 3;
  return count;
}

// The finest mesh that is not too much for its readers: silhouettes as fine as any flatness allows, then surfaces as
// near to the depths as silhouettes allow.
SurfacePart part_that_fits(const LayeredPanorama& panorama, const Job& job) {
  constexpr size_t kMostTriangles = 800'000;
  constexpr int kCoarsest = 8;
  const auto fits = [&](const SurfacePart& part) { return triangle_count(panorama, part, job) <= kMostTriangles; };
  SurfacePart part{0, panorama.grid.width, 1, kTolerances.back()};
  while (part.step < kCoarsest && !fits(part)) part.step *= 2;
  for (const int tolerance : kTolerances) {
    part.tolerance = tolerance;
    if (tolerance == kTolerances.back() || fits(part)) break;
  }
  return part;
}

}  // namespace

std::vector<uint8_t> export_glb(const LayeredPanorama& panorama, const ExportOptions& options, const Job& job) {
  GlbWriter writer(panorama, options, job);
  const SurfacePart part = part_that_fits(panorama, job);
  for (size_t i = 0; i < panorama.layers.size(); ++i) {
    job.report("exporting", static_cast<double>(i) / static_cast<double>(panorama.layers.size()));
    writer.add_layer(i, part);
  }
  return writer.finish();
}

}  // namespace ldp
