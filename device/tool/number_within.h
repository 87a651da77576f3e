// The range checks of options that take a number.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>
#include <string>

namespace ldp {

// None of what is no number, nan among it.
inline std::optional<double> number_of(const std::string& text) {
  double value = 0;
  if (!CLI::detail::lexical_cast(text, value) || std::isnan(value)) return std::nullopt;
  return value;
}

// CLI::Range, without nan, which that lets pass.
inline CLI::Validator number_within(double low, double high) {
  const CLI::Range range(low, high);
  return CLI::Validator(
      [range](std::string& text) { return number_of(text) ? range(text) : "Value " + text + " is not a number"; },
      range.get_description());
}

// CLI::Range, which of what is no whole number says only that it is out of range.
template <typename Whole>
CLI::Validator whole_within(Whole low, Whole high) {
  return CLI::Validator(
      [low, high](std::string& text) {
        Whole value = 0;
        if (CLI::detail::lexical_cast(text, value) && low <= value && value <= high) return std::string();
        return "Value " + text + " is not a whole number from " + std::to_string(low) + " to " + std::to_string(high);
      },
      CLI::Range(low, high).get_description());
}

// 0 besides, which means that nothing is given.
inline CLI::Validator zero_or_within(double low, double high) {
  const CLI::Validator within = number_within(low, high);
  return CLI::Validator(
      [within](std::string& text) {
        const std::optional<double> number = number_of(text);
        if (number == 0.0) return std::string();
        const std::string refusal = within(text);
        return refusal.empty() || !number ? refusal : refusal + " and is not 0";
      },
      "0 or " + within.get_description());
}

}  // namespace ldp
