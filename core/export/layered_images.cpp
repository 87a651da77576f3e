#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/captures/json_text.h"
#include "core/captures/transforms.h"
#include "core/export/export.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

std::string file_name(size_t layer, const char* what) { return "layer_" + std::to_string(layer + 1) + what + ".png"; }

Plane<uint8_t> opacity_of(const Layer& layer) {
  if (!layer.alpha.empty()) return layer.alpha;
  Plane<uint8_t> opacity = layer.coverage;
  for (uint8_t& sample : opacity.samples) sample = sample ? 255 : 0;
  return opacity;
}

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json grid_json(const PanoramaGrid& grid) {
  Json json;
  json["rays"] = grid.rays == Rays::central ? "central" : "pushbroom";
  json["width"] = grid.width, json["height"] = grid.height;
  json["wraps"] = grid.wraps;
  json["theta_left"] = grid.theta_left, json["theta_pitch"] = grid.theta_pitch;
  json["v_top"] = grid.v_top, json["v_pitch"] = grid.v_pitch;
  json["far_inverse_depth"] = grid.w_far, json["near_inverse_depth"] = grid.w_near;
  json["most_disparity"] = kDisparitySteps, json["no_disparity"] = kNoDisparity;
  json["arc_centre"] = vector_json(grid.arc.centre);
  json["arc_radius"] = grid.arc.radius;
  for (const int axis : {0, 1, 2})
    json[axis == 0 ? "arc_u0" : axis == 1 ? "arc_u90" : "arc_axis"] = vector_json(grid.arc.world_from_arc.col(axis));
  return json;
}

std::vector<uint8_t> layers_json(const LayeredPanorama& panorama) {
  Json json;
  json["software"] = "ldp";
  json["grid"] = grid_json(panorama.grid);
  for (size_t i = 0; i < panorama.layers.size(); ++i)
    json["layers"].push_back({{"image", file_name(i, "")}, {"disparity", file_name(i, "_disparity")}});
  json["cameras"] = Json::parse(transforms_json(panorama.cameras));
  const std::string text = json_text(json, 1) + "\n";
  return {text.begin(), text.end()};
}

}  // namespace

std::vector<ExportedFile> export_layers(const LayeredPanorama& panorama, const Job& job) {
  std::vector<ExportedFile> files;
  for (size_t i = 0; i < panorama.layers.size(); ++i) {
    job.check();
    const Layer& layer = panorama.layers[i];
    files.push_back({file_name(i, ""), encode_png(layer.colour, opacity_of(layer))});
    files.push_back({file_name(i, "_disparity"), encode_png(decode_depth(layer.depth, layer.coverage))});
  }
  files.push_back({"layers.json", layers_json(panorama)});
  return files;
}

}  // namespace ldp
