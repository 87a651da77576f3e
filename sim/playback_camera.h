// A camera that shows given pictures at the ticks of a real clock: what the folder and the scene camera have in common.
#pragma once

#include <functional>
#include <string>

#include "drivers/interface/camera.h"
#include "drivers/interface/ticker.h"
#include "drivers/interface/url.h"

namespace ldp {

struct Playback {
  std::string name;
  PixelFormat format = PixelFormat::mjpeg;
  int width = 0, height = 0;
  int64_t count = 0;
  std::function<CameraFrame(int64_t index)> frame;                    // picture, size and format; the rest is filled in
  std::function<bool(const std::function<bool()>& give_up)> prepare;  // as a camera's; none = nothing to do
};

class PlaybackCamera final : public CameraDevice {
 public:
  static constexpr const char* kOptions = "fps hold lost_after stall_after";

  // kOptions: see devices.h.
  struct Timing {
    double fps = 30;
    bool hold = true;
    int64_t lost_after = -1, stall_after = -1;  // -1 = never
  };
  static Timing timing_from(const Url& url);  // throws as Url does

  PlaybackCamera(const Timing& timing, Playback playback);

  std::string name() const override { return playback_.name; }
  CameraMode mode() const override;
  bool prepare(const std::function<bool()>& give_up) override;
  int fd() const override { return ticker_.fd(); }
  bool lock_exposure(bool) override { return true; }
  void start() override;
  void stop() override { ticker_.stop(); }
  std::optional<CameraFrame> read() override;

 private:
  Playback playback_;
  Timing timing_;
  Ticker ticker_;
  int64_t next_ = 0;
};

}  // namespace ldp
