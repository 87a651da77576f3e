// Any text as an ldpd.toml; what is accepted must come back from its own text.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "device/service/config/config.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const ldp::CheckedConfig read = ldp::parse_config(std::string(reinterpret_cast<const char*>(data), size));
  if (read.mistakes.empty() && !ldp::parse_config(ldp::config_text(read.config)).mistakes.empty()) std::abort();
  return 0;
}
