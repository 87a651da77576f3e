#include "tests/bench/verdict/judged_sweep.h"

#include <cmath>

#include "core/verdict/expectation.h"
#include "core/verdict/judge.h"
#include "core/verdict/words.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const DirectionEvidence& d) {
  return {d.pixels,   d.holes,        d.compared,      d.unexplained,
          d.back.sum, d.back.samples, d.neighbour.sum, d.neighbour.samples};
}

DirectionEvidence direction_from(const Json& json) {
  const auto number = [&](size_t i) { return json.at(i).get<int64_t>(); };
  return {number(0), number(1), number(2), number(3), {number(4), number(5)}, {number(6), number(7)}};
}

Json json_of(const PhotoEvidence& photo) {
  Json json{{"heading", photo.heading_deg},
            {"turn", photo.turn_deg},
            {"step", photo.step},
            {"forward", photo.forward},
            {"brightness", photo.measures.brightness},
            {"blur_x", photo.measures.blur_x},
            {"blur_y", photo.measures.blur_y},
            {"noise", photo.measures.noise},
            {"detail", photo.measures.detail},
            {"gain", photo.gain},
            {"shared", photo.shared_points},
            {"shift", photo.shift},
            {"far_shift", photo.far_shift},
            {"outward", photo.outward},
            {"sideward", photo.sideward},
            {"parallax_squares", photo.parallax_squares},
            {"parallax_points", photo.parallax_points}};
  json["directions"] = Json::array();
  for (const DirectionEvidence& part : photo.directions) json["directions"].push_back(json_of(part));
  return json;
}

PhotoEvidence photo_from(const Json& json) {
  PhotoEvidence photo;
  photo.heading_deg = json.at("heading");
  photo.turn_deg = json.at("turn"), photo.step = json.at("step"), photo.forward = json.at("forward");
  photo.measures = {json.at("brightness"), json.at("blur_x"), json.at("blur_y"), json.at("noise"), json.at("detail")};
  photo.gain = json.at("gain");
  photo.shared_points = json.at("shared");
  photo.shift = json.at("shift");
  photo.far_shift = json.at("far_shift");
  photo.outward = json.at("outward");
  photo.sideward = json.at("sideward");
  photo.parallax_squares = json.at("parallax_squares");
  photo.parallax_points = json.at("parallax_points");
  for (const Json& part : json.at("directions")) photo.directions.push_back(direction_from(part));
  return photo;
}

Json json_of(const SweepEvidence& evidence) {
  Json json{{"motion", static_cast<int>(evidence.motion)},
            {"doubt", static_cast<int>(evidence.doubt)},
            {"taken", evidence.photos_taken},
            {"field", evidence.field_deg},
            {"reprojection", evidence.reprojection},
            {"agreement", evidence.agreement},
            {"first", evidence.first_deg}};
  json["photos"] = Json::array();
  for (const PhotoEvidence& photo : evidence.photos) json["photos"].push_back(json_of(photo));
  return json;
}

SweepEvidence evidence_from(const Json& json) {
  SweepEvidence evidence;
  evidence.motion = static_cast<SweepMotion>(json.at("motion").get<int>());
  evidence.doubt = static_cast<DoubtfulPoses>(json.at("doubt").get<int>());
  evidence.photos_taken = json.at("taken");
  evidence.field_deg = json.at("field");
  evidence.reprojection = json.at("reprojection");
  evidence.agreement = json.value("agreement", 1.0);
  evidence.first_deg = json.at("first");
  for (const Json& photo : json.at("photos")) evidence.photos.push_back(photo_from(photo));
  return evidence;
}

Json json_of(const SweepQuality& quality) {
  Json reasons = Json::array();
  for (const QualityFinding& finding : quality.reasons)
    reasons.push_back(std::string(code_of(finding.reason)) + " " + std::to_string(std::lround(finding.from_deg)) + " " +
                      std::to_string(std::lround(finding.to_deg)));
  return {{"verdict", name_of(quality.grade)},
          {"expected", quality.expected_view_psnr_db},
          {"back", quality.photos_back_psnr_db},
          {"unexplained", quality.unexplained_share},
          {"reasons", reasons}};
}

}  // namespace

Json json_of(const JudgedSweep& sweep) {
  Json json{{"scene", sweep.scene}, {"seed", sweep.seed}, {"spoil", sweep.spoil}};
  if (!sweep.refused.empty()) {
    json["refused"] = sweep.refused;
    return json;
  }
  if (sweep.truth)
    json["truth"] = {{"psnr", sweep.truth->psnr_db},
                     {"matched", sweep.truth->matched_db},
                     {"holes", sweep.truth->holes},
                     {"ssim", sweep.truth->ssim}};
  json["notes"] = sweep.notes;
  json["quality"] = json_of(sweep.quality);
  json["features"] = features_of(sweep.evidence);
  json["evidence"] = json_of(sweep.evidence);
  return json;
}

JudgedSweep judged_again(const Json& line) {
  JudgedSweep sweep;
  sweep.scene = line.at("scene"), sweep.spoil = line.at("spoil"), sweep.seed = line.at("seed");
  sweep.refused = line.value("refused", "");
  if (!sweep.refused.empty()) return sweep;
  if (line.contains("truth")) {
    const Json& truth = line.at("truth");
    sweep.truth = {truth.at("psnr"), truth.at("matched"), truth.at("holes"), truth.at("ssim")};
  }
  sweep.notes = line.at("notes");
  sweep.evidence = evidence_from(line.at("evidence"));
  sweep.quality = judge(sweep.evidence);
  return sweep;
}

}  // namespace ldp
