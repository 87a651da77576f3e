#include "device/tool/switches.h"

#include <string_view>

namespace ldp {
namespace {

struct Words {
  std::string_view core, here;
};

constexpr Words kWords[] = {
    {"give the field of view", "give the field of view (--fov)"},
    {"a turn by 90 or by 270 degrees", "--turn 90 or --turn 270"},
    {"where it stood upright, no turn", "where it stood upright, no --turn"},
    {"leave the turn out", "leave --turn out"},
    {"memory_bytes", "--memory"},
    {"near_depth", "--near"},
    {"far_depth", "--far"},
};

// Not a part of a longer word, nor of a path.
bool stands_alone(const std::string& text, size_t at, size_t length) {
  const size_t after = at + length;
  const auto is_one_of = [&](size_t i, std::string_view allowed) { return allowed.find(text[i]) != allowed.npos; };
  return (at == 0 || is_one_of(at - 1, " (")) && (after == text.size() || is_one_of(after, " ),:;"));
}

}  // namespace

std::string with_switches(const std::string& message) {
  std::string text = message;
  for (const Words& words : kWords) {
    for (size_t at = 0; (at = text.find(words.core, at)) != std::string::npos; ++at) {
      const bool said = text.compare(at, words.here.size(), words.here) == 0;
      if (!said && stands_alone(text, at, words.core.size())) text.replace(at, words.core.size(), words.here);
    }
  }
  return text;
}

std::string in_shell(const std::vector<std::string>& words) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

std::vector<std::string> with_switches(const std::vector<std::string>& messages) {
  std::vector<std::string> texts;
  for (const std::string& message : messages) texts.push_back(with_switches(message));
  return texts;
}

}  // namespace ldp
