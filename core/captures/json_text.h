// JSON as text, whatever bytes the names of files in it are.
//
// Takes a value of nlohmann-json and the spaces by which each level is indented, -1 for all in one line; gives UTF-8
// without a line's end. What is no UTF-8 in its strings becomes U+FFFD, as by utf8 (core/base/markup_text.h): plain
// `dump` throws there.
#pragma once

#include <string>

namespace ldp {

template <typename Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ldp
