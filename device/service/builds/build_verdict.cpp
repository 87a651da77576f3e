#include "device/service/builds/build_verdict.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ldp {
namespace {

Judgement judgement_named(const std::string& name) {
  if (name == "good") return Judgement::good;
  if (name == "fair") return Judgement::fair;
  return name == "sweep_again" ? Judgement::sweep_again : Judgement::none;
}

}  // namespace

void add_verdict(const std::filesystem::path& report, Result& result) {
  std::ifstream file(report);
  const nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object() || !json.contains("quality")) return;
  try {
    const nlohmann::json& quality = json.at("quality");
    Result told = result;
    told.verdict = judgement_named(quality.at("verdict").get<std::string>());
    told.expected_view_psnr_db = quality.at("expected_view_psnr_db").get<double>();
    std::vector<std::string> lines;
    for (const nlohmann::json& reason : quality.at("reasons")) lines.push_back(reason.at("text").get<std::string>());
    for (const std::string& line : lines) told.reasons.append(line).append(&line == &lines.back() ? "" : "\n");
    result = std::move(told);
  } catch (const nlohmann::json::exception&) {
    return;  // of another version
  }
}

}  // namespace ldp
