// A sweep that was judged, and its line of JSON: everything that a verdict rests on, so that bounds and weights can be
// tried again without building again.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/verdict/evidence.h"
#include "core/verdict/sweep_quality.h"

namespace ldp {

struct TrueQuality {
  double psnr_db = 0, matched_db = 0, holes = 0,
         ssim = 0;  // means of the views; matched: exposure by a factor a channel
};

struct JudgedSweep {
  std::string scene, spoil;
  uint32_t seed = 0;
  std::string refused;  // why there is no panorama, if there is none
  std::optional<TrueQuality> truth;
  std::vector<std::string> notes;
  SweepEvidence evidence;
  SweepQuality quality;
};

nlohmann::ordered_json json_of(const JudgedSweep& sweep);

// Judges the evidence of such a line as judge.h does today. Throws nlohmann::json::exception where it is none.
JudgedSweep judged_again(const nlohmann::ordered_json& line);

}  // namespace ldp
