// A camera that shows given pictures at the ticks of a real clock: what the folder and the scene camera have in common.
#pragma once

#include <functional>
#include <string>

#include "camera.h"
#include "ticker.h"
#include "url.h"

namespace ldp {

struct Playback {
  std::string name;
  PixelFormat format = PixelFormat::mjpeg;
  int width = 0, height = 0;
  int64_t count = 0;
  std::function<CameraFrame(int64_t index)> frame;  // picture, size and format; the rest is filled in
};

class PlaybackCamera final : public CameraDevice {
 public:
  static constexpr const char* kOptions = "fps hold lost_after stall_after";

  // Reads kOptions from the URL: see devices.h.
  PlaybackCamera(const Url& url, Playback playback);

  std::string name() const override { return playback_.name; }
  CameraMode mode() const override;
  int fd() const override { return ticker_.fd(); }
  bool lock_exposure(bool) override { return true; }
  void start() override;
  void stop() override { ticker_.stop(); }
  std::optional<CameraFrame> read() override;

 private:
  Playback playback_;
  double fps_ = 30;
  bool hold_ = true;
  int64_t lost_after_ = -1, stall_after_ = -1;
  Ticker ticker_;
  int64_t next_ = 0;
};

}  // namespace ldp
