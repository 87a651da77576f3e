# The modules of the page, in an order in which each stands behind what it uses. The page has them one after the other
# without their imports: names at their top level occur once in each list.
set(web_worker_modules
  reader/errors.js reader/crc32c.js reader/byte_reader.js reader/container.js reader/records.js reader/range_decoder.js
  reader/coverage.js reader/block_ranges.js reader/depth_codes.js reader/opacity.js reader/image_size.js
  reader/guided_colour.js reader/colour.js reader/verdict.js reader/ldp_reader.js reader/browser_images.js
  surfaces/prepared_layer.js surfaces/code_smoother.js surfaces/underlay.js surfaces/frame_extension.js
  surfaces/strip_cells.js surfaces/torn_vertex.js surfaces/torn_quads.js surfaces/mesh.js
  surfaces/thumbnail.js surfaces/seen_map.js viewer/preparation.js viewer/worker.js)
set(web_viewer_modules
  surfaces/torn_vertex.js viewer/gl.js viewer/exposure.js viewer/surface_renderer.js viewer/background_fill.js
  viewer/scene.js viewer/viewpoint.js viewer/seen_share.js viewer/controls.js viewer/tilt.js viewer/headset.js viewer/frame.js
  page/page_worker.js layered_panorama.js page/show.js)

# web_script(OUT MODULE ...): modules as one script, without comments and indentation.
function(web_script out)
  set(script "")
  foreach(module ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/${module})
    file(READ ${PROJECT_SOURCE_DIR}/web/${module} text)
    string(REGEX REPLACE "/[*][*]([^*]|[*]+[^*/])*[*]+/" "" text "\n${text}")
    string(REGEX REPLACE "\nimport [^;]*;" "" text "${text}")
    string(REGEX REPLACE "\nexport " "\n" text "${text}")
    string(REGEX REPLACE "([\n ])// [^\n]*" "\\1" text "${text}")
    string(REGEX REPLACE "[ \n]*\n[ \n]*" "\n" text "${text}")
    string(APPEND script "${text}")
  endforeach()
  set(${out} "${script}" PARENT_SCOPE)
endfunction()

# web_packed(OUT TEXT): the bytes of a text, compressed (gzip), as numbers with commas.
function(web_packed out text)
  set(folder ${PROJECT_BINARY_DIR}/generated/web)
  file(WRITE ${folder}/text "${text}")
  file(ARCHIVE_CREATE OUTPUT ${folder}/text.gz PATHS ${folder}/text FORMAT raw COMPRESSION GZip COMPRESSION_LEVEL 9 MTIME 0)
  file(READ ${folder}/text.gz bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  set(${out} "${bytes}" PARENT_SCOPE)
endfunction()

# web_page(PAGE SCRIPTS): the page with the marks @SCRIPTS@ and @PANORAMA@ left in it, and the bytes of its scripts,
# compressed, as numbers with commas.
function(web_page page_out scripts_out)
  web_script(worker ${web_worker_modules})
  web_script(viewer ${web_viewer_modules})
  web_packed(bytes "${viewer}\n@next@\n${worker}")
  web_script(start page/start.js)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/page/page.html)
  file(READ ${PROJECT_SOURCE_DIR}/web/page/page.html page)
  string(REPLACE "@START@" "${start}" page "${page}")
  set(${page_out} "${page}" PARENT_SCOPE)
  set(${scripts_out} "${bytes}" PARENT_SCOPE)
endfunction()
