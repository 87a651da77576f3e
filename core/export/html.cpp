#include "core/export/export.h"

#include "core/base/markup_text.h"
#include "core/export/viewer_page.h"

namespace ldp {

std::string export_html(std::span<const uint8_t> ldp_file) {
  std::string page = kViewerPage;
  const auto put = [&page](const std::string& mark, std::span<const uint8_t> bytes) {
    page.replace(page.find(mark), mark.size(), base85(bytes));
  };
  put("@SCRIPTS@", kViewerScripts);
  put("@PANORAMA@", ldp_file);
  return page;
}

}  // namespace ldp
