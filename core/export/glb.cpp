#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/export/export.h"
#include "core/export/surface.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kTexturePx = 4096;     // columns of one texture: what every graphics chip takes
constexpr double kHorizon = 1000.0;  // points at infinity are drawn at this many times the arc's radius (or unit, if 0)
constexpr int kArrayBuffer = 34962, kIndexBuffer = 34963;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

class GlbWriter {
 public:
  GlbWriter(const LayeredPanorama& panorama, const Job& job) : panorama_(panorama), job_(job) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "layered-depth-panorama"}};
    json_["extensionsUsed"] = {"KHR_materials_unlit"};
    json_["scene"] = 0;
    json_["scenes"] = Json::array({Json{{"nodes", Json::array()}}});
    json_["samplers"] =
        Json::array({Json{{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 33071}, {"wrapT", 33071}}});
    for (const char* list : {"nodes", "meshes", "materials", "textures", "images", "accessors", "bufferViews"})
      json_[list] = Json::array();
  }

  void add_layer(size_t index, int step, const ExportOptions& options) {
    const RgbImage colour = spread_colour(panorama_.layers[index]);
    Json primitives = Json::array();
    for (int begin = 0; begin < panorama_.grid.width; begin += kTexturePx) {
      const int end = std::min(panorama_.grid.width, begin + kTexturePx);
      const Surface surface = make_surface(panorama_, index, {begin, end, step}, job_);
      if (!surface.triangles.empty()) primitives.push_back(add_part(surface, colour, begin, end, options));
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
                               "samplers", "extensionsUsed"})
        json_.erase(list);
    if (!binary_.empty()) json_["buffers"] = Json::array({Json{{"byteLength", binary_.size()}}});
    if (json_["scenes"][0]["nodes"].empty()) json_["scenes"][0].erase("nodes");
    std::string text = json_.dump();
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

  size_t add_positions(const Surface& surface) {
    const size_t begin = binary_.size();
    std::array<float, 3> least, most;
    least.fill(std::numeric_limits<float>::max());
    most.fill(std::numeric_limits<float>::lowest());
    for (const SurfaceVertex& vertex : surface.vertices) {
      const std::array<float, 3> p = position(vertex);
      for (size_t i = 0; i < 3; ++i) {
        least[i] = std::min(least[i], p[i]);
        most[i] = std::max(most[i], p[i]);
        put_u32(binary_, std::bit_cast<uint32_t>(p[i]));
      }
    }
    return add_accessor({{"bufferView", add_view(begin, kArrayBuffer)},
                         {"componentType", kFloat},
                         {"count", surface.vertices.size()},
                         {"type", "VEC3"},
                         {"min", least},
                         {"max", most}});
  }

  size_t add_texture_places(const Surface& surface, int begin_px, int width) {
    const size_t begin = binary_.size();
    const auto put = [&](double share) {
      const auto v = static_cast<uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * 65535));
      binary_.push_back(static_cast<uint8_t>(v & 255));
      binary_.push_back(static_cast<uint8_t>(v >> 8));
    };
    for (const SurfaceVertex& vertex : surface.vertices) {
      put((double{vertex.u_px} - begin_px) / width);
      put(double{vertex.v_px} / panorama_.grid.height);
    }
    return add_accessor({{"bufferView", add_view(begin, kArrayBuffer)},
                         {"componentType", kUnsignedShort},
                         {"normalized", true},
                         {"count", surface.vertices.size()},
                         {"type", "VEC2"}});
  }

  size_t add_indices(const Surface& surface) {
    const size_t begin = binary_.size();
    for (const uint32_t index : surface.triangles) put_u32(binary_, index);
    return add_accessor({{"bufferView", add_view(begin, kIndexBuffer)},
                         {"componentType", kUnsignedInt},
                         {"count", surface.triangles.size()},
                         {"type", "SCALAR"}});
  }

  // One column more than the part, for the quads that lead to the next one.
  size_t add_material(const RgbImage& colour, int begin, int end, const ExportOptions& options) {
    RgbImage part(end - begin + 1, colour.height);
    for (int y = 0; y < part.height; ++y)
      for (int x = 0; x < part.width; ++x) {
        const int from = begin + x < colour.width ? begin + x : panorama_.grid.wraps ? 0 : colour.width - 1;
        part.at(x, y) = colour.at(from, y);
      }
    const size_t at = binary_.size();
    const std::vector<uint8_t> jpeg = encode_jpeg(part, options.quality);
    binary_.insert(binary_.end(), jpeg.begin(), jpeg.end());
    json_["images"].push_back({{"bufferView", add_view(at, 0)}, {"mimeType", "image/jpeg"}});
    json_["textures"].push_back({{"sampler", 0}, {"source", json_["images"].size() - 1}});
    json_["materials"].push_back({{"pbrMetallicRoughness",
                                   {{"baseColorTexture", {{"index", json_["textures"].size() - 1}}},
                                    {"metallicFactor", 0},
                                    {"roughnessFactor", 1}}},
                                  {"doubleSided", true},
                                  {"extensions", {{"KHR_materials_unlit", Json::object()}}}});
    return json_["materials"].size() - 1;
  }

  Json add_part(const Surface& surface, const RgbImage& colour, int begin, int end, const ExportOptions& options) {
    const size_t positions = add_positions(surface);
    const size_t places = add_texture_places(surface, begin, end - begin + 1);
    const size_t indices = add_indices(surface);
    const size_t material = add_material(colour, begin, end, options);
    return {{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", places}}},
            {"indices", indices},
            {"material", material}};
  }

  const LayeredPanorama& panorama_;
  const Job& job_;
  Json json_;
  std::vector<uint8_t> binary_;
};

size_t triangle_count(const LayeredPanorama& panorama, int step, const Job& job) {
  size_t count = 0;
  for (size_t layer = 0; layer < panorama.layers.size(); ++layer)
    count += make_surface(panorama, layer, {0, panorama.grid.width, step}, job).triangles.size() / 3;
  return count;
}

// The finest mesh that is not too much for its readers.
int step_that_fits(const LayeredPanorama& panorama, const Job& job) {
  constexpr size_t kMostTriangles = 1'500'000;
  constexpr int kCoarsest = 8;
  int step = 1;
  while (step < kCoarsest && triangle_count(panorama, step, job) > kMostTriangles) step *= 2;
  return step;
}

}  // namespace

std::vector<uint8_t> export_glb(const LayeredPanorama& panorama, const ExportOptions& options, const Job& job) {
  GlbWriter writer(panorama, job);
  const int step = step_that_fits(panorama, job);
  for (size_t i = 0; i < panorama.layers.size(); ++i) {
    job.report("exporting", static_cast<double>(i) / static_cast<double>(panorama.layers.size()));
    writer.add_layer(i, step, options);
  }
  return writer.finish();
}

}  // namespace ldp
