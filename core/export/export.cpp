#include "core/export/export.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "core/captures/transforms.h"
#include "core/export/equirectangular.h"
#include "core/export/picture_metadata.h"

namespace ldp {
namespace {

enum class Form { jpeg, png, glb, html, json, ply };

Form form_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".jpg" || extension == ".jpeg") return Form::jpeg;
  if (extension == ".png") return Form::png;
  if (extension == ".glb") return Form::glb;
  if (extension == ".html" || extension == ".htm") return Form::html;
  if (extension == ".json") return Form::json;
  if (extension == ".ply") return Form::ply;
  throw std::runtime_error(file.string() + ": cannot export to " +
                           (extension.empty() ? "a name without an ending" : "'" + extension + "'") +
                           ": choose .jpg, .png, .glb, .ply, .html, .json, or a folder with a slash behind its name");
}

std::vector<uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

std::vector<uint8_t> stereo_file(const std::string& ending, const LayeredPanorama& panorama, const Renderer& renderer,
                                 const Viewer& viewer, int jpeg_quality, const Job& job) {
  const auto [left, right] = see_around_in_stereo(panorama, renderer, viewer, job);
  return picture_file(ending, top_bottom(left, right), stereo_xmp(panorama), panorama, jpeg_quality);
}

}  // namespace

std::vector<uint8_t> export_seen(const std::filesystem::path& file, LayeredPanorama&& panorama, Kind kind,
                                 const Viewer& viewer, const ExportOptions& options, const Job& job) {
  const Form form = form_of(file);
  if (form != Form::jpeg && form != Form::png)
    throw std::runtime_error(file.string() + ": what is seen from a place is a picture: .jpg or .png");
  const std::string ending = form == Form::png ? ".png" : ".jpg";
  LayeredPanorama frame;
  frame.grid = panorama.grid;
  frame.cameras = panorama.cameras;
  frame.metadata = panorama.metadata;
  Renderer renderer(std::move(panorama));
  renderer.prepare(job);  // from one place all of it is seen
  if (kind == Kind::stereo) return stereo_file(ending, frame, renderer, viewer, options.quality, job);
  const FlatPanorama flat = see_around(frame, renderer, viewer.at, job);
  if (kind == Kind::depth) return depth_file(ending, flat, frame, options.quality);
  return picture_file(ending, flat.image, gpano_xmp(flat, frame), frame, options.quality);
}

void check_export_name(const std::filesystem::path& file) { form_of(file); }

std::vector<uint8_t> export_as(const std::filesystem::path& file, const LayeredPanorama& panorama,
                               std::span<const uint8_t> ldp_file, const ExportOptions& options, const Job& job) {
  switch (form_of(file)) {
    case Form::jpeg:
      return export_jpeg(panorama, options);
    case Form::png:
      return export_png(panorama);
    case Form::glb:
      return export_glb(panorama, options, job);
    case Form::html:
      return bytes_of(export_html(ldp_file));
    case Form::ply:
      return export_ply(panorama, job);
    case Form::json:
      break;
  }
  return bytes_of(transforms_json(panorama.cameras));
}

}  // namespace ldp
