// ldp info: everything that is in an .ldp file.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "core/geometry/degrees.h"
#include "core/panorama/file/ldp_file.h"
#include "core/verdict/words.h"
#include "device/tool/commands.h"
#include "device/tool/json/quality_json.h"
#include "device/tool/output.h"
#include "device/tool/panorama_input.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json depth_json(double inverse_depth) { return inverse_depth > 0 ? Json(1 / inverse_depth) : Json("infinity"); }

Json grid_json(const PanoramaGrid& grid) {
  Json json;
  json["width"] = grid.width;
  json["height"] = grid.height;
  json["rays"] = grid.rays == Rays::pushbroom ? "pushbroom" : "central";
  json["wraps"] = grid.wraps;
  json["covered_degrees"] = grid.width * grid.theta_pitch * kDegreesPerRadian;
  json["theta_left"] = grid.theta_left;
  json["theta_pitch"] = grid.theta_pitch;
  json["v_top"] = grid.v_top;
  json["v_pitch"] = grid.v_pitch;
  json["nearest_depth"] = depth_json(grid.w_near);
  json["farthest_depth"] = depth_json(grid.w_far);
  return json;
}

// Where nothing is nearer than infinity no photo told it from any other.
bool radius_is_assumed(const PanoramaGrid& grid) { return grid.w_near == 0 && grid.arc.radius > 0; }

Json arc_json(const PanoramaGrid& grid) {
  const Arc& arc = grid.arc;
  Json json;
  json["centre"] = vector_json(arc.centre);
  json["axis"] = vector_json(arc.axis());
  json["radius"] = arc.radius;
  json["radius_assumed"] = radius_is_assumed(grid);
  json["covered_degrees"] = (arc.theta_end - arc.theta_begin) * kDegreesPerRadian;
  json["closed"] = arc.closed;
  return json;
}

struct CodingNames {
  const char *json, *text;
};

CodingNames names_of(ColourCoding coding) {
  switch (coding) {
    case ColourCoding::webp:
      return {"webp", "WebP"};
    case ColourCoding::webp_lossless:
      return {"webp_lossless", "lossless WebP"};
    case ColourCoding::jpeg:
      return {"jpeg", "JPEG"};
  }
  throw std::logic_error("names_of: no coding of colours");
}

Json colour_json(const std::set<ColourCoding>& codings) {
  Json names = Json::array();
  for (const ColourCoding coding : codings) names.push_back(names_of(coding).json);
  return names;
}

std::string colour_text(const std::set<ColourCoding>& codings) {
  std::string text;
  for (const ColourCoding coding : codings)
    text += (text.empty() ? ", colours in " : " and ") + std::string(names_of(coding).text);
  return text;
}

Json layers_json(const LdpReader& reader) {
  Json layers = Json::array();
  const LdpDescription& description = reader.description();
  const PanoramaGrid& grid = description.panorama.grid;
  const double pixels = static_cast<double>(grid.width) * grid.height;
  for (size_t i = 0; i < description.layers.size(); ++i) {
    const LdpLayerSummary& layer = description.layers[i];
    layers.push_back({{"coverage", static_cast<double>(layer.present_pixels) / pixels},
                      {"present_pixels", layer.present_pixels},
                      {"block_px", layer.block_px},
                      {"strip_px", layer.strip_px},
                      {"alpha", layer.has_alpha},
                      {"colour", colour_json(reader.colour_codings(static_cast<int>(i)))}});
  }
  return layers;
}

Json cameras_json(const std::vector<Camera>& cameras) {
  Json json = Json::array();
  for (const Camera& camera : cameras) {
    json.push_back({{"name", camera.name},
                    {"width", camera.intrinsics.width},
                    {"height", camera.intrinsics.height},
                    {"focal_px", camera.intrinsics.fx},
                    {"centre", vector_json(camera.pose.centre)}});
  }
  return json;
}

// The least and the greatest factor of green.
std::pair<double, double> exposure_range(const DisplayExposure& exposure) {
  int least = UINT16_MAX, most = 0;
  for (const auto& node : exposure.factors.nodes.samples)
    least = std::min<int>(least, node[1]), most = std::max<int>(most, node[1]);
  return {least / double{GainField::kOne}, most / double{GainField::kOne}};
}

Json info_json(const LdpReader& reader) {
  const LdpDescription& description = reader.description();
  const LayeredPanorama& panorama = description.panorama;
  Json json;
  json["version"] = description.version;
  json["bytes"] = description.file_bytes;
  json["grid"] = grid_json(panorama.grid);
  json["arc"] = arc_json(panorama.grid);
  json["limits"] = {{"inner_radius", panorama.limits.inner_radius},
                    {"outer_radius", panorama.limits.outer_radius},
                    {"height", panorama.limits.height}};
  json["layers"] = layers_json(reader);
  json["cameras"] = cameras_json(panorama.cameras);
  if (!panorama.exposure.empty()) {
    const auto [least, most] = exposure_range(panorama.exposure);
    json["exposure"] = {{"columns", panorama.exposure.factors.nodes.width},
                        {"rows", panorama.exposure.factors.nodes.height},
                        {"least", least},
                        {"most", most}};
  }
  json["quality"] = quality_json(panorama.quality);
  json["metadata"] = panorama.metadata;
  json["thumbnail_bytes"] = description.thumbnail.size();
  json["chunks"] = Json::array();
  for (const LdpChunk& chunk : description.chunks) {
    json["chunks"].push_back({{"type", chunk.type},
                              {"layer", chunk.layer},
                              {"strip", chunk.strip},
                              {"offset", chunk.offset},
                              {"bytes", chunk.length},
                              {"crc32c", chunk.crc32c}});
  }
  return json;
}

// Sums over strips: what matters to people is how much each kind takes.
void print_sizes(const LdpDescription& description) {
  std::map<std::pair<int, std::string>, uint64_t> sizes;
  for (const LdpChunk& chunk : description.chunks) sizes[{chunk.layer, chunk.type}] += chunk.length;
  for (const auto& [key, bytes] : sizes) {
    const std::string where = key.first < 0 ? "file" : "layer " + std::to_string(key.first + 1);
    std::printf("  %-8s %s %10llu bytes  %5.1f %%\n", where.c_str(), printable(key.second).c_str(),
                static_cast<unsigned long long>(bytes),
                100.0 * static_cast<double>(bytes) / static_cast<double>(description.file_bytes));
  }
}

std::string depth_text(double inverse_depth) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", inverse_depth > 0 ? 1 / inverse_depth : 0.0);
  return inverse_depth > 0 ? text : "infinity";
}

void print_quality(const std::map<std::string, double>& figures) {
  const std::optional<SweepQuality> quality = quality_from(figures);
  if (quality) {
    std::printf("verdict   %s\n", text_of(*quality).c_str());
    std::printf("quality   photos rendered back %.2f dB, %.2f %% of their pixels unexplained\n",
                quality->photos_back_psnr_db, 100 * quality->unexplained_share);
    for (const DirectionQuality& d : quality->by_direction)
      std::printf("quality   %4.0f to %4.0f degrees: %-11s views of %.1f dB, photos rendered back %.1f dB\n",
                  d.from_deg, d.to_deg, text_of(d.grade), d.expected_view_psnr_db, d.photos_back_psnr_db);
  }
  for (const auto& [name, value] : figures)
    if (!quality || !is_of_verdict(name)) std::printf("quality   %s %.4g\n", printable(name).c_str(), value);
}

void print_text(const std::string& file, const LdpReader& reader) {
  const LdpDescription& description = reader.description();
  const LayeredPanorama& panorama = description.panorama;
  const PanoramaGrid& grid = panorama.grid;
  std::printf("%s: layered depth panorama, version %d, %llu bytes\n", printable(file).c_str(), description.version,
              static_cast<unsigned long long>(description.file_bytes));
  std::printf("picture   %dx%d, %s rays, %.1f degrees%s\n", grid.width, grid.height,
              grid.rays == Rays::pushbroom ? "pushbroom" : "central", grid.width * grid.theta_pitch * kDegreesPerRadian,
              grid.wraps ? ", closed" : "");
  std::printf("depths    %s to %s\n", depth_text(grid.w_near).c_str(), depth_text(grid.w_far).c_str());
  std::printf("arc       radius %.4g%s, %.1f degrees, %zu cameras\n", grid.arc.radius,
              radius_is_assumed(grid) ? " (assumed, or given with the cameras: the photos show no parallax)" : "",
              (grid.arc.theta_end - grid.arc.theta_begin) * kDegreesPerRadian, panorama.cameras.size());
  std::printf("views     from %.3g to %.3g of the axis, %.3g up and down\n", panorama.limits.inner_radius,
              panorama.limits.outer_radius, panorama.limits.height);
  for (size_t i = 0; i < description.layers.size(); ++i) {
    const double share =
        static_cast<double>(description.layers[i].present_pixels) / (static_cast<double>(grid.width) * grid.height);
    std::printf("layer %zu   %.1f %% covered%s%s\n", i + 1, 100 * share,
                description.layers[i].has_alpha ? ", soft edges" : "",
                colour_text(reader.colour_codings(static_cast<int>(i))).c_str());
  }
  if (!panorama.exposure.empty()) {
    const auto [least, most] = exposure_range(panorama.exposure);
    std::printf("exposure  local: light by %.2f to %.2f of even exposure\n", least, most);
  }
  print_quality(panorama.quality);
  for (const auto& [name, value] : panorama.metadata)
    std::printf("metadata  %s: %s\n", printable(name).c_str(), printable(value).c_str());
  std::printf("sizes\n");
  print_sizes(description);
}

int run(const PanoramaInput& input, const Session& session) {
  const std::string& file = input.file;
  check_input_file(file);
  Job job;
  job.threads = session.thread_count();
  job.stop = session.stop;
  const MappedFile mapped(file);
  try {
    const std::vector<std::string> damages = verify_panorama(input, mapped.bytes(), job);
    if (!damages.empty()) throw LdpError(damages.front());
    const LdpReader reader(mapped.bytes());
    if (session.json)
      std::printf("%s\n", json_text(info_json(reader), 1).c_str());
    else
      print_text(file, reader);
  } catch (const LdpError& error) {
    throw BadInput(file + ": " + refusal_of(mapped.bytes(), error.what()));
  }
  return kDone;
}

}  // namespace

void add_info(Program& program) {
  auto input = std::make_shared<PanoramaInput>();
  CLI::App& app = add_command(program, "info", "Print everything that is in an .ldp file",
                              [input](const Session& session) { return run(*input, session); });
  add_panorama_input(app, *input);
}

}  // namespace ldp
