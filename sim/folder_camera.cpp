#include <algorithm>
#include <cctype>
#include <filesystem>

#include "clocks.h"
#include "devices.h"
#include "images.h"
#include "ticker.h"

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

class FolderCamera final : public CameraDevice {
 public:
  explicit FolderCamera(const Url& url) : url_(url) {
    url.allow_only("fps hold lost_after stall_after");
    files_ = pictures_in(url.path());
    fps_ = url.number("fps", 30, {0.1, 1000});
    hold_ = url.flag("hold", true);
    lost_after_ = url.integer("lost_after", -1, {0, 1e9});
    stall_after_ = url.integer("stall_after", -1, {0, 1e9});
    const ImageSize size = read_image_size(files_.front());
    mode_ = {ends_like(files_.front(), {".png"}) ? PixelFormat::rgb24 : PixelFormat::mjpeg, size.width, size.height,
             fps_};
  }

  std::string name() const override { return url_.text(); }
  CameraMode mode() const override { return mode_; }
  int fd() const override { return ticker_.fd(); }
  bool lock_exposure(bool) override { return true; }

  void start() override {
    next_ = 0;
    start_ns_ = monotonic_now_ns();
    ticker_.start_at(start_ns_ + interval_ns(), interval_ns());
  }
  void stop() override { ticker_.stop(); }

  std::optional<CameraFrame> read() override {
    if (ticker_.take_expirations() == 0) return std::nullopt;
    const int64_t index = next_;
    if (stall_after_ >= 0 && index >= stall_after_) return std::nullopt;
    if (lost_after_ >= 0 && index >= lost_after_) throw CameraLost("the simulated camera was unplugged");
    const int64_t count = static_cast<int64_t>(files_.size());
    if (index >= count && !hold_) throw CameraLost("the folder has no more frames");
    ++next_;
    return frame(index, files_[static_cast<size_t>(std::min(index, count - 1))]);
  }

 private:
  int64_t interval_ns() const { return static_cast<int64_t>(1e9 / fps_); }

  CameraFrame frame(int64_t index, const std::filesystem::path& file) const {
    CameraFrame result;
    result.sequence = index;
    result.time_ns = monotonic_now_ns();
    const ImageSize size = read_image_size(file);
    result.width = size.width;
    result.height = size.height;
    if (ends_like(file, {".png"})) {
      auto image = std::make_shared<const RgbImage>(read_image(file));
      result.format = PixelFormat::rgb24;
      const size_t bytes = image->samples.size() * sizeof(Rgb);
      result.planes = {{&image->samples.data()->r, bytes, image->width * 3}};
      result.lease = std::move(image);
    } else {
      auto bytes = std::make_shared<const std::vector<uint8_t>>(read_file(file));
      result.planes = {{bytes->data(), bytes->size(), 0}};
      result.lease = std::move(bytes);
    }
    return result;
  }

  Url url_;
  std::vector<std::filesystem::path> files_;
  double fps_ = 30;
  bool hold_ = true;
  int64_t lost_after_ = -1, stall_after_ = -1;
  CameraMode mode_;
  Ticker ticker_;
  int64_t next_ = 0, start_ns_ = 0;
};

}  // namespace

std::unique_ptr<CameraDevice> open_folder_camera(const Url& url) { return std::make_unique<FolderCamera>(url); }

}  // namespace ldp
