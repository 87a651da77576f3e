// How back-ends are named: scheme:path?option=value&option=value, e.g. "v4l2:/dev/video0?width=1280&fps=30".
//
// Errors are std::runtime_error with one line that names the URL, the option and what is allowed.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace ldp {

struct NumberRange {
  double low = 0, high = 0;
};

class Url {
 public:
  // `text` must have a scheme. Options are split at the first '?'.
  explicit Url(std::string_view text);

  const std::string& text() const { return text_; }
  const std::string& scheme() const { return scheme_; }
  const std::string& path() const { return path_; }
  const std::string& rest() const { return rest_; }  // everything after the scheme, options included

  double number(const std::string& option, double otherwise, NumberRange range) const;
  int integer(const std::string& option, int otherwise, NumberRange range) const;
  bool flag(const std::string& option, bool otherwise) const;  // 0, 1, no, yes, false, true
  std::string word(const std::string& option, const std::string& otherwise) const;

  // Throws if the URL has an option that is not among `known` (separated by spaces).
  void allow_only(std::string_view known) const;

 private:
  std::string text_, scheme_, path_, rest_;
  std::map<std::string, std::string> options_;
};

}  // namespace ldp
