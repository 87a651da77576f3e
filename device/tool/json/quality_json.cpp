#include "device/tool/json/quality_json.h"

#include "core/verdict/words.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

Json finding_json(const QualityFinding& finding) {
  return {{"code", code_of(finding.reason)},
          {"text", text_of(finding)},
          {"from_deg", finding.from_deg},
          {"to_deg", finding.to_deg}};
}

Json direction_json(const DirectionQuality& direction) {
  return {{"from_deg", direction.from_deg},
          {"to_deg", direction.to_deg},
          {"verdict", name_of(direction.grade)},
          {"expected_view_psnr_db", direction.expected_view_psnr_db},
          {"photos_back_psnr_db", direction.photos_back_psnr_db},
          {"unexplained_share", direction.unexplained_share}};
}

}  // namespace

Json quality_json(const SweepQuality& quality) {
  Json json{{"verdict", name_of(quality.grade)},
            {"reasons", Json::array()},
            {"expected_view_psnr_db", quality.expected_view_psnr_db},
            {"photos_back_psnr_db", quality.photos_back_psnr_db},
            {"unexplained_share", quality.unexplained_share},
            {"by_direction", Json::array()}};
  for (const QualityFinding& finding : quality.reasons) json["reasons"].push_back(finding_json(finding));
  for (const DirectionQuality& direction : quality.by_direction)
    json["by_direction"].push_back(direction_json(direction));
  return json;
}

Json quality_json(const std::map<std::string, double>& figures) {
  const std::optional<SweepQuality> quality = quality_from(figures);
  Json json = quality ? quality_json(*quality) : Json::object();
  for (const auto& [name, value] : figures)
    if (!quality || !is_of_verdict(name)) json[name] = value;
  return json;
}

}  // namespace ldp
