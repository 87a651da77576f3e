// One sweep of the camera from its first frame until its last one is stored: frames in, chosen frames to the writer,
// guidance out.
//
// Takes frames until `end`; then it stores: the writer has frames of it still. When nothing of it waits any more,
// `finish_storing` says so and the sweep is over.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/base/plane.h"
#include "core/photos/images.h"
#include "device/capture/capture_store.h"
#include "device/capture/frame_selection.h"
#include "device/capture/frame_writer.h"
#include "device/service/config/config.h"
#include "device/service/reasons.h"
#include "drivers/interface/camera.h"

namespace ldp {

class SweepRun {
 public:
  // Starts the camera; frames go into `folder`, which is there. `writer` must live longer.
  SweepRun(const Config& config, std::unique_ptr<CameraDevice> camera, std::filesystem::path folder,
           FrameWriter& writer);

  // While it takes frames.
  bool takes() const { return camera_ != nullptr; }
  int fd() const { return camera_ ? camera_->fd() : -1; }
  // Takes the oldest frame that waits, one at a time: a camera that is faster than frames can be looked at must not
  // keep the loop from the button. Throws CameraLost.
  void read_frame();
  bool full(int64_t now_ns) const;     // all the way round, or the limits are reached
  bool stalled(int64_t now_ns) const;  // the camera has been silent for too long
  int64_t deadline_ns() const;         // when to ask the two again
  int chosen() const { return static_cast<int>(record_.frames.size()); }
  Guidance guidance() const { return chooser_.guidance(); }
  bool stands_still() const { return chooser_.stands_still(); }
  // Guidance that is due, at most one in kGuidanceInterval_ns.
  std::optional<Guidance> next_guidance(int64_t now_ns);

  // Stops the camera and gives it back; queues the last frame and the final capture.json. `complete` = the person or a
  // limit ended it.
  void end(const Reason& reason, bool complete);

  // Until everything is on disk.
  void note(const WriteOutcome& outcome);  // of this sweep's folder
  bool stores() const { return stores_; }
  void finish_storing() { stores_ = false; }
  int frames_stored() const { return frames_stored_; }
  const Reason& storage_problem() const { return storage_problem_; }  // the first one, if there was one

  const std::filesystem::path& folder() const { return folder_; }
  int64_t end_ns() const { return end_ns_; }  // 0 = it goes on
  Reason too_few_frames() const;              // to build from: why it came to so few

 private:
  void take(CameraFrame frame);
  bool is_of_the_sweep(ImageSize size);
  bool settled(const CameraFrame& frame, double brightness);
  void store(const CameraFrame& frame);

  Config config_;
  std::unique_ptr<CameraDevice> camera_;  // none once it has ended
  std::filesystem::path folder_;
  FrameWriter& writer_;
  FrameChooser chooser_;
  CaptureRecord record_;
  std::optional<ImageSize> size_;  // that all must have; none before the first
  ImageSize last_size_;            // before that: of the last frame, and
  int alike_ = 0;                  // how many in a row had it
  GreyImage first_thumbnail_;      // whose size all others must have, too
  std::optional<CameraFrame> held_;
  double settle_s_ = 0;
  bool settled_ = false;
  int steady_frames_ = 0;
  double last_brightness_ = -1;
  int64_t start_ns_ = 0, last_frame_ns_ = 0, first_frame_time_ns_ = 0, next_guidance_ns_ = 0, end_ns_ = 0;
  Reason end_reason_;
  bool stores_ = false;
  int frames_stored_ = 0;
  Reason storage_problem_;
};

}  // namespace ldp
