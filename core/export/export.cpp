#include "export.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "transforms.h"

namespace ldp {

std::vector<uint8_t> export_as(const std::filesystem::path& file, const LayeredPanorama& panorama,
                               const ExportOptions& options) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto bytes = [](const std::string& text) { return std::vector<uint8_t>(text.begin(), text.end()); };
  if (extension == ".jpg" || extension == ".jpeg") return export_jpeg(panorama, options);
  if (extension == ".png") return export_png(panorama);
  if (extension == ".glb") return export_glb(panorama, options);
  if (extension == ".html" || extension == ".htm") return bytes(export_html(panorama, options));
  if (extension == ".json") return bytes(transforms_json(panorama.cameras));
  throw std::runtime_error(file.string() + ": cannot export to '" + extension + "': .jpg, .png, .glb, .html or .json");
}

}  // namespace ldp
