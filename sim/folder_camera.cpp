#include <algorithm>
#include <cctype>
#include <filesystem>

#include "core/base/files.h"
#include "core/photos/images.h"
#include "sim/devices.h"
#include "sim/playback_camera.h"

namespace ldp {
namespace {

bool ends_like(const std::filesystem::path& file, std::initializer_list<const char*> endings) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return std::any_of(endings.begin(), endings.end(), [&](const char* ending) { return extension == ending; });
}

std::vector<std::filesystem::path> pictures_in(const std::string& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (ends_like(entry.path(), {".jpg", ".jpeg", ".png"})) files.push_back(entry.path());
  }
  if (error) throw std::runtime_error("cannot read the folder '" + folder + "' as a camera: " + error.message());
  if (files.empty()) throw std::runtime_error("no .jpg or .png file in '" + folder + "' to show as camera frames");
  std::sort(files.begin(), files.end());
  return files;
}

CameraFrame frame_from(const std::filesystem::path& file) {
  CameraFrame frame;
  const ImageSize size = read_image_size(file);
  frame.width = size.width;
  frame.height = size.height;
  if (ends_like(file, {".png"})) {
    auto image = std::make_shared<const RgbImage>(read_image(file));
    frame.format = PixelFormat::rgb24;
    frame.planes = {{&image->samples.data()->r, image->samples.size() * sizeof(Rgb), image->width * 3}};
    frame.lease = std::move(image);
  } else {
    auto bytes = std::make_shared<const std::vector<uint8_t>>(read_file(file));
    frame.format = PixelFormat::mjpeg;
    frame.planes = {{bytes->data(), bytes->size(), 0}};
    frame.lease = std::move(bytes);
  }
  return frame;
}

}  // namespace

void check_folder_camera(const Url& url) {
  url.allow_only(PlaybackCamera::kOptions);
  PlaybackCamera::timing_from(url);
}

std::unique_ptr<CameraDevice> open_folder_camera(const Url& url) {
  check_folder_camera(url);
  auto files = pictures_in(url.path());
  const ImageSize size = read_image_size(files.front());
  Playback playback;
  playback.name = url.text();
  playback.format = ends_like(files.front(), {".png"}) ? PixelFormat::rgb24 : PixelFormat::mjpeg;
  playback.width = size.width;
  playback.height = size.height;
  playback.count = static_cast<int64_t>(files.size());
  playback.frame = [files = std::move(files)](int64_t index) { return frame_from(files[static_cast<size_t>(index)]); };
  return std::make_unique<PlaybackCamera>(PlaybackCamera::timing_from(url), std::move(playback));
}

}  // namespace ldp
