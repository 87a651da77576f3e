// What became of many builds: told from the reports and .ldp files of a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ldp {

// Of one build; what neither a report nor a file tells is absent.
struct BuildOutcome {
  std::string name;     // of the file or report without its ending, with its folder below the one summed up
  std::string verdict;  // "good", "fair", "sweep_again", "failed", "unknown"
  std::string reasons;  // in words: of the verdict or the failure
  std::optional<double> expected_view_psnr_db, processor_seconds;
  std::optional<uint64_t> file_bytes, peak_memory_bytes;
  std::optional<int> exit_status, photos, posed;
  std::vector<uint8_t> thumbnail;  // JPEG
};

struct Totals {
  size_t good = 0, fair = 0, sweep_again = 0, failed = 0, unknown = 0;
  double processor_seconds = 0;
  uint64_t file_bytes = 0, peak_memory_bytes = 0;  // the latter the largest
};

// Of a folder and those in it, by name: NAME.ldp and the report NAME.json are one build. Other files are passed over.
// Throws BadInput where there is no such folder, std::system_error where it cannot be read.
std::vector<BuildOutcome> outcomes_in(const std::filesystem::path& folder);

Totals totals_of(const std::vector<BuildOutcome>& outcomes);

nlohmann::ordered_json summary_json(const std::vector<BuildOutcome>& outcomes);
std::string summary_table(const std::vector<BuildOutcome>& outcomes);

// One page that needs no network, the worst first, thumbnails inside.
std::string summary_page(const std::string& title, const std::vector<BuildOutcome>& outcomes);

}  // namespace ldp
