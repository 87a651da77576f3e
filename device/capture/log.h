// Lines for people who look after the device: standard error, with journald's priorities when it listens.
#pragma once

#include <string>

namespace ldp {

void log_warning(const std::string& text);
void log_note(const std::string& text);

}  // namespace ldp
