// core names its fields, which a library's users set; this program sets them by switches.
#pragma once

#include <string>
#include <vector>

namespace ldp {

// A message of core in this program's words: a field by the switch that sets it, "near_depth" by "--near"; advice to
// give a value with its switch beside it, "give the field of view" with "(--fov)".
std::string with_switches(const std::string& message);
std::vector<std::string> with_switches(const std::vector<std::string>& messages);

// Words as a shell takes them, those that need it between quotes.
std::string in_shell(const std::vector<std::string>& words);

}  // namespace ldp
