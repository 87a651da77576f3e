// The verdict on a sweep as JSON (DESIGN 3, "Verdict").
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/verdict/sweep_quality.h"

namespace ldp {

nlohmann::ordered_json quality_json(const SweepQuality& quality);

// Of a file's figures: the verdict, if they hold one, and whatever other figures there are, by name.
nlohmann::ordered_json quality_json(const std::map<std::string, double>& figures);

}  // namespace ldp
