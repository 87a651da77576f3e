#include "device/gallery/status_json.h"

namespace ldp::gallery {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Status& status) {
  return {{"type", "status"},    {"phase", name_of(status.phase)},        {"capture", status.capture},
          {"text", status.text}, {"frames_stored", status.frames_stored}, {"sweeps_left", status.sweeps_left}};
}

Json json_of(const Progress& progress) {
  return {
      {"type", "progress"}, {"capture", progress.capture}, {"stage", progress.stage}, {"fraction", progress.fraction}};
}

Json json_of(const Guidance& guidance) {
  return {{"type", "guidance"},
          {"advice", name_of(guidance.advice)},
          {"covered_rad", guidance.covered_rad},
          {"speed_rad_s", guidance.speed_rad_s},
          {"tilt_px", guidance.tilt_px},
          {"brightness", guidance.brightness},
          {"frames_chosen", guidance.frames_chosen}};
}

Json json_of(const Result& result) {
  return {{"type", "result"},
          {"ok", result.ok},
          {"capture", result.capture},
          {"file", result.file},
          {"text", result.text},
          {"seconds", result.seconds},
          {"verdict", name_of(result.verdict)},
          {"expected_view_psnr_db", result.expected_view_psnr_db},
          {"reasons", result.reasons}};
}

}  // namespace

Json json_from(const StatusMessage& message) {
  return std::visit([](const auto& told) { return json_of(told); }, message);
}

}  // namespace ldp::gallery
