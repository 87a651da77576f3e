#include "device/capture/log.h"

#include <cstdlib>

#include "core/base/markup_text.h"
#include "drivers/interface/standard_streams.h"

namespace ldp {
namespace {

void put(const char* priority, const char* word, const std::string& text) {
  const bool journal = std::getenv("JOURNAL_STREAM") != nullptr;
  say((journal ? priority : "") + (word + printable(text)));
}

}  // namespace

void log_warning(const std::string& text) { put("<4>", "warning: ", text); }
void log_note(const std::string& text) { put("<6>", "", text); }

}  // namespace ldp
