#include "core/export/export.h"
#include "core/export/viewer_page.h"

namespace ldp {
namespace {

std::string base64(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string export_html(std::span<const uint8_t> ldp_file) {
  std::string page = kViewerPage;
  const auto put = [&page](const std::string& mark, std::span<const uint8_t> bytes) {
    page.replace(page.find(mark), mark.size(), base64(bytes));
  };
  put("@SCRIPTS@", kViewerScripts);
  put("@PANORAMA@", ldp_file);
  return page;
}

}  // namespace ldp
