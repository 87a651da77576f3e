// How much work a build does: each level is one row of a table, and nothing else asks for the level.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ldp {

enum class Effort : uint8_t { fast, standard, best };

struct EffortOptions {
  std::string_view name;  // as on the command line
  double pitch_px;        // rows of the photos to a row of the panorama, where memory and the file allow it
  int iterations;         // 1 .. 4, see BuildOptions
  int substeps;           // depths tried inside each label's interval, in the last iteration
  int cycles;             // of expansion after message passing, for depth and for colour
  int columns_apart;      // of the photographs' columns, those that are asked the following
  // Whether something suits them better, pixel by pixel: the surfaces so many pixels above and below, then those so
  // many pixels to the left, the right, above and below.
  std::span<const int> upright_px, propagation_px;
};

namespace efforts {  // figures: decisions.md
inline constexpr std::array kUprightPx{28};
inline constexpr std::array kFastPropagationPx{4};
inline constexpr std::array kStandardPropagationPx{8, 3, 1};
inline constexpr std::array kBestPropagationPx{16, 8, 4, 2, 1};
inline constexpr std::array<EffortOptions, 3> kTable = {{
    {"fast", 1.25, 1, 4, 0, 2, kUprightPx, kFastPropagationPx},
    {"standard", 1.0, 2, 8, 1, 2, kUprightPx, kStandardPropagationPx},
    {"best", 2.0 / 3, 2, 16, 1, 1, kUprightPx, kBestPropagationPx},
}};
}  // namespace efforts

constexpr const EffortOptions& options_of(Effort effort) { return efforts::kTable[static_cast<size_t>(effort)]; }

inline std::vector<std::string> effort_names() {
  std::vector<std::string> names;
  for (const EffortOptions& effort : efforts::kTable) names.emplace_back(effort.name);
  return names;
}

constexpr std::optional<Effort> effort_named(std::string_view name) {
  for (size_t i = 0; i < efforts::kTable.size(); ++i)
    if (efforts::kTable[i].name == name) return static_cast<Effort>(i);
  return {};
}

}  // namespace ldp
