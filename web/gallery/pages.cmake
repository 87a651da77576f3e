# The gallery's pages and scripts, and the viewer's, in a header: each compressed (gzip).
include(${CMAKE_CURRENT_LIST_DIR}/../page/modules.cmake)
set(web_gallery_modules gallery/api.js gallery/cards.js gallery/live.js gallery/gallery.js)
set(web_gallery_viewer_modules ${web_viewer_modules})
list(TRANSFORM web_gallery_viewer_modules REPLACE "^page/page_worker.js$" "viewer/start_worker.js")
list(TRANSFORM web_gallery_viewer_modules REPLACE "^page/show.js$" "gallery/show.js")

# gallery_pages(HEADER): writes it.
function(gallery_pages header)
  web_script(gallery ${web_gallery_modules})
  web_script(viewer ${web_gallery_viewer_modules})
  web_script(worker ${web_worker_modules})
  foreach(page index view)
    set(source ${PROJECT_SOURCE_DIR}/web/gallery/${page}.html)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(READ ${source} ${page})
  endforeach()
  web_packed(gallery_page "${index}")
  web_packed(view_page "${view}")
  web_packed(gallery_script "${gallery}")
  web_packed(viewer_script "${viewer}")
  web_packed(worker_script "${worker}")
  file(CONFIGURE OUTPUT ${header} CONTENT "#pragma once

#include <cstdint>

namespace ldp::gallery {

inline constexpr uint8_t kGalleryPage[] = {@gallery_page@};
inline constexpr uint8_t kViewPage[] = {@view_page@};
inline constexpr uint8_t kGalleryScript[] = {@gallery_script@};
inline constexpr uint8_t kViewerScript[] = {@viewer_script@};
inline constexpr uint8_t kWorkerScript[] = {@worker_script@};

}  // namespace ldp::gallery
" @ONLY)
endfunction()
