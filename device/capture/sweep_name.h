// The names of captures: sweep_000012.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace ldp {

inline constexpr std::string_view kSweepPrefix = "sweep_";
inline constexpr int kMostSweeps = 999'999'999;  // nine digits; six at least

inline std::optional<int> number_of_sweep(std::string_view name) {
  if (!name.starts_with(kSweepPrefix)) return std::nullopt;
  const std::string_view digits = name.substr(kSweepPrefix.size());
  const bool good = digits.size() >= 6 && digits.size() <= 9 &&
                    std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  return good ? std::optional(std::stoi(std::string(digits))) : std::nullopt;
}

}  // namespace ldp
