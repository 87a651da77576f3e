#include <algorithm>
#include <cctype>
#include <filesystem>

#include "core/base/files.h"
#include "core/captures/folder_frames.h"
#include "core/photos/images.h"
#include "sim/devices.h"
#include "sim/playback_camera.h"

namespace ldp {
namespace {

bool is_png(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".png";
}

CameraFrame frame_from(const std::filesystem::path& file) {
  CameraFrame frame;
  const ImageSize size = read_image_size(file);
  frame.width = size.width;
  frame.height = size.height;
  if (is_png(file)) {
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
  auto files = photos_of_capture(url.path());
  const std::filesystem::path first = files.front().path;
  const ImageSize size = read_image_size(first);
  Playback playback;
  playback.name = url.text();
  playback.format = is_png(first) ? PixelFormat::rgb24 : PixelFormat::mjpeg;
  playback.width = size.width;
  playback.height = size.height;
  playback.count = static_cast<int64_t>(files.size());
  playback.frame = [files = std::move(files)](int64_t index) {
    return frame_from(files[static_cast<size_t>(index)].path);
  };
  return std::make_unique<PlaybackCamera>(PlaybackCamera::timing_from(url), std::move(playback));
}

}  // namespace ldp
