// What one build tells of itself: report.json (seconds, memory, energies, poses, coverage, sizes), and lines for
// people.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/pipeline/build.h"

namespace ldp {

nlohmann::ordered_json report_json(const BuildReport& report, const LayeredPanorama& panorama);
nlohmann::ordered_json poses_json(const PosesReport& poses);

// A line to standard output for each photo that takes no part, and why; one for all that are needless.
void print_left_out(const PosesReport& poses);

// Sizes by chunk type and layer of an encoded file.
nlohmann::ordered_json sizes_json(std::span<const uint8_t> file);

int64_t peak_memory_bytes();  // of this process so far

}  // namespace ldp
