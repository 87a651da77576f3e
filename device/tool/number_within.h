// The range check of every option that takes a number with a fraction.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace ldp {

// CLI::Range, which lets nan pass, without it.
inline CLI::Validator number_within(double low, double high) {
  const CLI::Range range(low, high);
  return CLI::Validator(
      [low, high, range](std::string& text) {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return std::string();
        const std::string refusal = range(text);
        return refusal.empty() ? "Value " + text + " is not a number" : refusal;
      },
      range.get_description());
}

// 0 besides, which means that nothing is given.
inline CLI::Validator zero_or_within(double low, double high) {
  const CLI::Validator within = number_within(low, high);
  return CLI::Validator(
      [within](std::string& text) {
        double value = 1;
        if (CLI::detail::lexical_cast(text, value) && value == 0) return std::string();
        const std::string refusal = within(text);
        return refusal.empty() ? refusal : refusal + " and is not 0";
      },
      "0 or " + within.get_description());
}

}  // namespace ldp
