#include "device/tool/own_output.h"

#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "core/base/files.h"
#include "device/tool/output.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

constexpr size_t kHead = 1 << 16;  // bytes at the beginning that tell a kind: all metadata of a picture among them

std::string_view text_of(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Of cameras each frame has a pose; a capture's record has frames too, but no poses. Cameras of another program may be
// the work of days.
bool holds_our_cameras(const nlohmann::json& json) {
  if (!json.is_object() || !json.contains("frames") || !json["frames"].is_array()) return false;
  if (!json.contains("software") || json["software"] != "ldp") return false;
  for (const auto& frame : json["frames"])
    if (!frame.is_object() || !frame.contains("transform_matrix")) return false;
  return true;
}

bool is_of(OutputKind kind, const fs::path& file) {
  const MappedFile mapped(file);
  const std::string_view all = text_of(mapped.bytes()), head = all.substr(0, kHead);
  const auto says = [&](std::string_view words) { return head.find(words) != std::string_view::npos; };
  switch (kind) {
    case OutputKind::panorama:
      return head.starts_with("\xABLDP");
    case OutputKind::report:
      return is_report(nlohmann::ordered_json::parse(all, nullptr, false));
    case OutputKind::cameras:
      return file.filename() != "capture.json" && holds_our_cameras(nlohmann::json::parse(all, nullptr, false));
    case OutputKind::picture:
      return says("GPano:ProjectionType=\"equirectangular\"") && says("GPano:StitchingSoftware=\"ldp ");
    case OutputKind::mesh:
      return head.starts_with("glTF") && says("layered-depth-panorama");
    case OutputKind::cloud:
      return head.starts_with("ply\n") && says("comment layered-depth-panorama");
    case OutputKind::viewer:
      return says("<title>Layered depth panorama</title>");
    case OutputKind::summary:
      return says(std::string("<title>") + kSummaryTitle);
    case OutputKind::film:
      return all.find(kRendered) != std::string_view::npos;  // where its metadata lie is the container's choice
  }
  return false;
}

const char* words_for(OutputKind kind) {
  switch (kind) {
    case OutputKind::panorama:
      return ".ldp file";
    case OutputKind::report:
      return "report of a build";
    case OutputKind::cameras:
      return "transforms.json of this program";
    case OutputKind::picture:
      return "flat panorama of this program";
    case OutputKind::mesh:
      return "mesh of this program";
    case OutputKind::cloud:
      return "point cloud of this program";
    case OutputKind::viewer:
      return "viewer of this program";
    case OutputKind::summary:
      return "summary of this program";
    case OutputKind::film:
      return "film that tells it was rendered by this program";
  }
  return "";
}

}  // namespace

bool is_report(const nlohmann::ordered_json& json) {
  if (!json.is_object() || !json.contains("options")) return false;
  return json.contains("failure") || (json.contains("seconds") && json.contains("panorama"));
}

OutputKind exported_kind(const fs::path& file) {
  const std::string extension = extension_of(file);
  if (extension == ".json") return OutputKind::cameras;
  if (extension == ".glb") return OutputKind::mesh;
  if (extension == ".ply") return OutputKind::cloud;
  return extension.starts_with(".htm") ? OutputKind::viewer : OutputKind::picture;
}

void check_output_file(const fs::path& file, OutputKind kind) {
  if (kind == OutputKind::panorama)
    check_output_file(file, ".ldp");
  else if (kind == OutputKind::report || kind == OutputKind::cameras)
    check_output_file(file, ".json");
  else
    check_output_file(file);
  std::error_code error;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) == 0) return;
  check_input_file(file);  // what cannot be read cannot be told
  if (!is_of(kind, file))
    throw BadInput(file.string() + ": exists and is no " + words_for(kind) +
                   ": choose another name, or remove it first");
}

}  // namespace ldp
