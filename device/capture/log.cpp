#include "device/capture/log.h"

#include <cstdio>
#include <cstdlib>

namespace ldp {
namespace {

void put(const char* priority, const char* word, const std::string& text) {
  const bool journal = std::getenv("JOURNAL_STREAM") != nullptr;
  std::fprintf(stderr, "%s%s%s\n", journal ? priority : "", word, text.c_str());
}

}  // namespace

void log_warning(const std::string& text) { put("<4>", "warning: ", text); }
void log_note(const std::string& text) { put("<6>", "", text); }

}  // namespace ldp
