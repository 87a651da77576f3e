#include "drivers/interface/url.h"

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "drivers/interface/plain_number.h"

namespace ldp {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw std::runtime_error("'" + text + "': " + why);
}

}  // namespace

Url::Url(std::string_view text) : text_(text) {
  const size_t colon = text_.find(':');
  if (colon == std::string::npos || colon == 0)
    refuse(text_, "no scheme; expected something like 'v4l2:/dev/video0' of a camera or 'lcm:' of a status");
  scheme_ = text_.substr(0, colon);
  rest_ = text_.substr(colon + 1);
  const size_t question = rest_.find('?');
  path_ = rest_.substr(0, question);
  if (question == std::string::npos) return;
  std::istringstream query(rest_.substr(question + 1));
  for (std::string pair; std::getline(query, pair, '&');) {
    if (pair.empty()) continue;
    const size_t equals = pair.find('=');
    const std::string value = equals == std::string::npos ? std::string("1") : pair.substr(equals + 1);
    options_[pair.substr(0, equals)] = value;
  }
}

double Url::number(const std::string& option, double otherwise, NumberRange range) const {
  const auto found = options_.find(option);
  if (found == options_.end()) return otherwise;
  char* end = nullptr;
  const double value = std::strtod(found->second.c_str(), &end);
  const bool whole = !found->second.empty() && *end == '\0' && std::isfinite(value);
  if (!whole || value < range.low || value > range.high) {
    refuse(text_, option + " is '" + found->second + "', expected a number from " + plain_number(range.low) + " to " +
                      plain_number(range.high));
  }
  return value;
}

int Url::integer(const std::string& option, int otherwise, NumberRange range) const {
  const double value = number(option, otherwise, range);
  if (value != std::floor(value)) refuse(text_, option + " is " + plain_number(value) + ", expected a whole number");
  return static_cast<int>(value);
}

bool Url::flag(const std::string& option, bool otherwise) const {
  const std::string value = word(option, otherwise ? "1" : "0");
  if (value == "1" || value == "yes" || value == "true") return true;
  if (value == "0" || value == "no" || value == "false") return false;
  refuse(text_, option + " is '" + value + "', expected yes or no");
}

std::string Url::word(const std::string& option, const std::string& otherwise) const {
  const auto found = options_.find(option);
  return found == options_.end() ? otherwise : found->second;
}

void Url::allow_only(std::string_view known) const {
  for (const auto& [option, value] : options_) {
    std::istringstream words{std::string(known)};
    bool found = false;
    for (std::string word; words >> word;) found = found || word == option;
    if (!found) {
      refuse(text_, "unknown option '" + option + "'" +
                        (known.empty() ? std::string("; none is known here") : "; known: " + std::string(known)));
    }
  }
}

}  // namespace ldp
