// A layered depth panorama in forms that other programs open.
//
//   .jpg .png   flat equirectangular panorama of what is seen first, the rest filled from around it, with GPano (XMP)
//               so that panorama viewers know which part of the sphere it is; .jpg also with EXIF
//   .glb        the layers as textured meshes that tear at depth edges (glTF 2.0, unlit); y is up, the arc's centre is
//               the origin. Coded for size (EXT_meshopt_compression, EXT_texture_webp), or plain for readers of bare
//               glTF
//   .html       a viewer with parallax (web/) in one file that needs no network, the .ldp file inside
//   .json       transforms.json of the source cameras
//   .ply        the points of all layers in the world of those cameras, but for those at infinity: x y z (float), red
//               green blue, layer (1 = front); binary
//   a folder    layered images: layer_1.png ... (RGBA) and layer_1_disparity.png ... (16 bits: 0 .. 3825 of the range
//   of
//               inverse depth, 65535 = nothing there), on the grid that layers.json tells, with the cameras
//
// A pushbroom panorama flattened is what it is: every column seen from its own place of the arc. What an eye, or two,
// see from one place is rendered from the layers: export_seen.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/export/around.h"
#include "core/panorama/panorama.h"

namespace ldp {

// Seen all around from a place (around.h): by one eye; by two, a whole sphere for each, the left one's above; by one
// eye with depth (picture_metadata.h): a .jpg with it inside, or depth alone as a .png of 16 bits.
enum class Kind : uint8_t { panorama, stereo, depth };

struct ExportOptions {
  int quality = 90;    // of JPEG images, 1 .. 100; WebP textures look alike
  bool plain = false;  // .glb without extensions that readers must know
};

std::vector<uint8_t> export_jpeg(const LayeredPanorama& panorama, const ExportOptions& options);
std::vector<uint8_t> export_png(const LayeredPanorama& panorama);
// Of .jpg or .png by the file's ending.
std::vector<uint8_t> export_seen(const std::filesystem::path& file, LayeredPanorama&& panorama, Kind kind,
                                 const Viewer& viewer, const ExportOptions& options = {}, const Job& job = {});
std::vector<uint8_t> export_glb(const LayeredPanorama& panorama, const ExportOptions& options, const Job& job = {});
std::vector<uint8_t> export_ply(const LayeredPanorama& panorama, const Job& job = {});
std::string export_html(std::span<const uint8_t> ldp_file);

struct ExportedFile {
  std::string name;
  std::vector<uint8_t> bytes;
};
std::vector<ExportedFile> export_layers(const LayeredPanorama& panorama, const Job& job = {});

// By the file's extension, in capitals or not; std::runtime_error that lists the known ones for any other, which
// check_export_name throws before any work is done. `ldp_file`: what the panorama was decoded from.
std::vector<uint8_t> export_as(const std::filesystem::path& file, const LayeredPanorama& panorama,
                               std::span<const uint8_t> ldp_file, const ExportOptions& options = {},
                               const Job& job = {});
void check_export_name(const std::filesystem::path& file);

}  // namespace ldp
