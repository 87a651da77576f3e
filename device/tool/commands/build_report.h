// report.json: seconds, memory, energies, poses, coverage and sizes of one build.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/pipeline/build.h"

namespace ldp {

nlohmann::ordered_json report_json(const BuildReport& report, const LayeredPanorama& panorama);
nlohmann::ordered_json poses_json(const PosesReport& poses);

// Sizes by chunk type and layer of an encoded file.
nlohmann::ordered_json sizes_json(std::span<const uint8_t> file);

int64_t peak_memory_bytes();  // of this process so far

}  // namespace ldp
