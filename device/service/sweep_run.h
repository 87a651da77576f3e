// One sweep of the camera: frames in, chosen frames to the writer, guidance out.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "device/capture/capture_store.h"
#include "device/capture/frame_selection.h"
#include "device/capture/frame_writer.h"
#include "device/service/config.h"
#include "drivers/interface/camera.h"

namespace ldp {

class SweepRun {
 public:
  // Starts the camera. `writer` must live longer.
  SweepRun(const Config& config, std::unique_ptr<CameraDevice> camera, std::filesystem::path folder,
           FrameWriter& writer);

  int fd() const { return camera_->fd(); }
  // Takes the oldest frame that waits, one at a time: a camera that is faster than frames can be looked at must not
  // keep the loop from the button. Throws CameraLost.
  void read_frame();

  bool full(int64_t now_ns) const;     // all the way round, or the limits are reached
  bool stalled(int64_t now_ns) const;  // the camera has been silent for too long
  int64_t deadline_ns() const;         // when to ask the two again
  int chosen() const { return static_cast<int>(record_.frames.size()); }
  Guidance guidance() const { return chooser_.guidance(); }

  // Stops the camera; queues the last frame and the final capture.json. `complete` = the person or a limit ended it.
  void end(const std::string& reason, bool complete);

 private:
  void take(CameraFrame frame);
  bool settled(const CameraFrame& frame, double brightness);
  void store(const CameraFrame& frame);

  Config config_;
  std::unique_ptr<CameraDevice> camera_;
  std::filesystem::path folder_;
  FrameWriter& writer_;
  FrameChooser chooser_;
  CaptureRecord record_;
  std::optional<CameraFrame> held_;
  double settle_s_ = 0;
  bool settled_ = false;
  int steady_frames_ = 0;
  double last_brightness_ = -1;
  int64_t start_ns_ = 0, last_frame_ns_ = 0, first_frame_time_ns_ = 0;
};

}  // namespace ldp
