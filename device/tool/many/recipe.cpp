#include "device/tool/many/recipe.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <vector>

#include "core/base/files.h"
#include "core/captures/json_text.h"
#include "core/captures/transforms.h"
#include "device/tool/panorama_input.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

// FNV-1a of 64 bits, in hexadecimal digits.
std::string digits_of(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
  return digits;
}

std::vector<fs::path> inputs_of(const BuildSetup& setup, const Intake& intake) {
  std::vector<fs::path> inputs = intake.inputs();
  if (setup.cameras.empty()) return inputs;
  inputs.emplace_back(setup.cameras);
  if (fs::is_directory(setup.cameras))
    for (const auto& entry : fs::directory_iterator(setup.cameras)) inputs.push_back(entry.path());
  return inputs;
}

}  // namespace

std::string recipe_of(const BuildSetup& setup, const PreparedBuild& prepared) {
  nlohmann::ordered_json json = options_json(setup, prepared.options);
  for (const char* const plays_no_part : {"capture", "cameras", "debug_directory"}) json.erase(plays_no_part);
  json["version"] = LDP_VERSION;
  if (!prepared.options.cameras.empty()) json["cameras"] = transforms_json(prepared.options.cameras);
  for (const PhotoFile& photo : prepared.frames.files())
    json["photos"].push_back({photo.path.filename().string(), fs::file_size(photo.path)});
  json["device"] = {prepared.notes.device, prepared.notes.captured_utc};
  return digits_of(json_text(json));
}

std::optional<LdpDescription> made_already(const std::string& output, const std::string& recipe,
                                           const BuildSetup& setup, const PreparedBuild& prepared, const Job& job) {
  std::error_code absent;
  const fs::file_time_type made = fs::last_write_time(output, absent);
  if (absent) return std::nullopt;
  for (const fs::path& input : inputs_of(setup, prepared.intake)) {
    const fs::file_time_type changed = fs::last_write_time(input, absent);
    if (!absent && changed > made) return std::nullopt;
  }
  try {
    const MappedFile mapped(output);
    LdpDescription description = describe_ldp(mapped.bytes());
    const auto found = description.panorama.metadata.find(kRecipe);
    if (found == description.panorama.metadata.end() || found->second != recipe) return std::nullopt;
    const PanoramaInput input{output, 0};
    if (!verify_panorama(input, mapped.bytes(), job).empty()) return std::nullopt;
    return description;
  } catch (const LdpError&) {
    return std::nullopt;
  }
}

}  // namespace ldp
