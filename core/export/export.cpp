#include "core/export/export.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "core/captures/transforms.h"

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
                           ": .jpg, .png, .glb, .ply, .html, .json, or a folder with a slash behind its name");
}

std::vector<uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

}  // namespace

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
