// Which frames of a sweep to keep, and what to tell the person: from thumbnails alone, whatever the arm's speed.
//
// Takes every camera frame in order as a thumbnail with its sharpness and time. Gives, for each, what to do with it:
// neighbours that are kept overlap by at least the wanted share, and of the frames that would do the sharpest is kept.
// How: the shift against the last kept frame (image_shift.h), or, where the two do not match, added up over the frames
// since. Between 60 % and 100 % of the wanted step the sharpest frame is held; it is kept when a frame passes the step.
// Where that sum has a gap (the arm jumped from rest), frames that match each other but not the last kept one tell that
// the step was passed.
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/plane.h"
#include "device/capture/image_shift.h"
#include "drivers/interface/status.h"

namespace ldp {

struct ChooserOptions {
  double overlap = 0.75;  // of neighbours, at least, where the camera is fast enough; 0.3 .. 0.95
  int max_frames = 80;    // 3 .. 1000
  double fov_rad = 1.13;  // horizontal; a guess does, it only scales the angles that are shown
};

struct OfferedFrame {
  GreyImage thumbnail;
  double sharpness = 0;
  int64_t time_ns = 0;
  std::optional<double> exposure_s;
};

// In this order: store what is held, store this frame, hold this frame instead of what was held.
struct Verdict {
  bool store_held = false, store_this = false, hold_this = false;
};

class FrameChooser {
 public:
  explicit FrameChooser(const ChooserOptions& options);

  Verdict offer(const OfferedFrame& frame);
  bool finish();  // the sweep is over: true if the held frame is worth storing

  bool full() const { return full_; }  // the first frame's content came round again, or max_frames
  Guidance guidance() const;
  bool stands_still() const;  // all that was seen is what the first frame showed; false while too little was

 private:
  struct Seen {
    GreyImage thumbnail;
    double sharpness = 0;
    double step = 0;  // shares of the image width turned since the reference
  };

  double step_to(const GreyImage& thumbnail, double* tilt_px);
  std::optional<double> step_seen(const GreyImage& thumbnail, double* tilt_px);
  double step_along(const GreyImage& thumbnail, double* tilt_px);
  void keep(const Seen& seen);
  bool consider(const Seen& seen);
  void measure_speed(const OfferedFrame& frame);
  bool came_round(const GreyImage& thumbnail);
  bool shows_the_first_place(const GreyImage& thumbnail) const;

  ChooserOptions options_;
  std::optional<GreyImage> first_;
  std::optional<Shift> first_seen_;  // from the first frame to the one before, once nearly round
  std::optional<Seen> reference_, held_, previous_;
  int direction_ = 0;  // +1: content moves left, the camera turns right
  int frames_ = 0;
  bool blind_ = false;  // since the reference the turn was guessed, not seen
  int astray_ = 0;      // frames in a row that match the one before, but lie who knows how far from the reference
  bool full_ = false;
  bool moved_ = false;
  int still_frames_ = 0;
  double turned_before_ = 0;  // shares of the width from the first frame to the reference
  double turned_ = 0;         // ... to now
  double tilt_before_ = 0, tilt_ = 0;
  double speed_ = 0;  // shares of the width per second, smoothed
  double brightness_ = 0;
  double blur_limit_ = 0;  // speed at which motion blurs
  double frame_interval_s_ = 0;
  int64_t last_ns_ = 0, slow_since_ns_ = 0;
};

}  // namespace ldp
