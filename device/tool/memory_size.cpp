#include "device/tool/memory_size.h"

#include <algorithm>

namespace ldp {

CLI::Validator memory_size(const std::string& zero_means) {
  const auto read = [zero_means](std::string& text) -> std::string {
    const size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
    std::string refusal = "'" + text +
                          "' is not a size such as 128M or 1G, a whole number of bytes, K, M, G or T, nor 0 for " +
                          zero_means;
    if (digits == 0 || text.find_first_of("-+. \t0123456789", digits) != std::string::npos) return refusal;
    try {
      CLI::AsSizeValue(false)(text);
      return {};
    } catch (const CLI::ValidationError&) {
      return refusal;
    }
  };
  return {read, "SIZE"};
}

}  // namespace ldp
