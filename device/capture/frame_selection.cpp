#include "device/capture/frame_selection.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "device/capture/capture_tuning.h"

namespace ldp {
namespace {

void check(bool good, const char* what) {
  if (!good) throw std::logic_error(std::string("frame choice: ") + what);
}

}  // namespace

FrameChooser::FrameChooser(const ChooserOptions& options)
    : options_(options), blur_limit_(kMaxBlur / kUsualExposure_s) {
  check(options.overlap >= 0.3 && options.overlap <= 0.95, "overlap must be within 0.3 .. 0.95");
  check(options.max_frames >= 3 && options.max_frames <= 1000, "max_frames must be within 3 .. 1000");
  check(options.fov_rad > 0 && options.fov_rad < std::numbers::pi, "fov_rad must be within 0 .. pi");
}

Verdict FrameChooser::offer(const OfferedFrame& frame) {
  brightness_ = mean_brightness(frame.thumbnail);
  if (frame.exposure_s && *frame.exposure_s > 0) blur_limit_ = kMaxBlur / *frame.exposure_s;
  Verdict verdict;
  Seen seen{frame.thumbnail, frame.sharpness, 0};
  if (!reference_) {
    first_ = frame.thumbnail;
    last_ns_ = slow_since_ns_ = frame.time_ns;
    keep(seen);
    previous_ = std::move(seen);
    verdict.store_this = true;
    return verdict;
  }
  moved_ = moved_ || !shows_the_first_place(frame.thumbnail);
  if (!moved_) ++still_frames_;
  const double wanted = 1 - options_.overlap;
  seen.step = step_to(seen.thumbnail, &tilt_);
  if (seen.step > wanted && held_) {
    verdict.store_held = true;
    const double beyond = seen.step - held_->step;
    keep(*held_);
    previous_.reset();
    seen.step = step_seen(seen.thumbnail, &tilt_).value_or(beyond);
  }
  if (seen.step > wanted && frames_ < options_.max_frames) {
    verdict.store_this = true;
    keep(seen);
    seen.step = 0;
  } else if (consider(seen)) {
    verdict.hold_this = true;
    held_ = seen;
  }
  turned_ = turned_before_ + seen.step;
  measure_speed(frame);
  full_ = full_ || frames_ >= options_.max_frames || came_round(seen.thumbnail);
  previous_ = std::move(seen);
  return verdict;
}

bool FrameChooser::finish() {
  const bool worth = held_ && held_->step >= kWorthAtEnd * (1 - options_.overlap) && frames_ < options_.max_frames;
  if (worth) keep(*held_);
  held_.reset();
  return worth;
}

// Turn since the reference in the sweep's direction, in shares of the image width.
double FrameChooser::step_to(const GreyImage& thumbnail, double* tilt_px) {
  const auto seen = step_seen(thumbnail, tilt_px);
  return seen ? *seen : step_along(thumbnail, tilt_px);
}

// None for a frame that does not show what the reference shows.
std::optional<double> FrameChooser::step_seen(const GreyImage& thumbnail, double* tilt_px) {
  const Shift direct = estimate_shift(reference_->thumbnail, thumbnail);
  if (direct.match < kGoodMatch) return std::nullopt;
  blind_ = false;
  astray_ = 0;
  *tilt_px = tilt_before_ + direct.dy_px;
  const double left = -direct.dx_px / thumbnail.width;  // content moves left: the camera turns right
  return direction_ == 0 ? std::abs(left) : direction_ * left;
}

// By way of the frame before.
double FrameChooser::step_along(const GreyImage& thumbnail, double* tilt_px) {
  const Shift chained = estimate_shift(previous_->thumbnail, thumbnail);
  if (chained.match < kGoodMatch) {
    blind_ = true;
    return previous_->step + speed_ * frame_interval_s_;  // on as before
  }
  *tilt_px = tilt_before_ + chained.dy_px;
  const double left = -chained.dx_px / thumbnail.width;
  const double step = previous_->step + (direction_ == 0 ? std::abs(left) : direction_ * left);
  astray_ = blind_ || std::abs(chained.dx_px) < kStill_px ? astray_ + 1 : 0;
  return astray_ < kAstrayFrames ? step : std::max(step, kPassedStep * (1 - options_.overlap));
}

void FrameChooser::keep(const Seen& seen) {
  if (reference_) {
    const Shift shift = estimate_shift(reference_->thumbnail, seen.thumbnail);
    const bool sure = shift.match >= kGoodMatch;  // a direction taken from anything else could be the wrong one
    if (sure && direction_ == 0) direction_ = shift.dx_px <= 0 ? 1 : -1;
    if (sure) tilt_before_ += shift.dy_px;
  }
  turned_before_ += seen.step;
  reference_ = seen;
  reference_->step = 0;
  held_.reset();
  blind_ = false;
  astray_ = 0;
  ++frames_;
}

// Whether to hold this frame rather than the held one.
bool FrameChooser::consider(const Seen& seen) {
  const double wanted = 1 - options_.overlap;
  if (frames_ >= options_.max_frames || seen.step < kWorthAtEnd * wanted || seen.step > wanted) return false;
  if (!held_) return true;
  const bool held_is_early = held_->step < kHoldFrom * wanted;
  if (held_is_early) return seen.step > held_->step;
  if (seen.step < kHoldFrom * wanted) return false;
  const auto score = [&](const Seen& s) { return s.sharpness * (1 - kStepWeight + kStepWeight * s.step / wanted); };
  return score(seen) >= score(*held_);
}

void FrameChooser::measure_speed(const OfferedFrame& frame) {
  const double seconds = static_cast<double>(frame.time_ns - last_ns_) * 1e-9;
  last_ns_ = frame.time_ns;
  if (seconds <= 0 || !previous_) return;
  const Shift since = estimate_shift(previous_->thumbnail, frame.thumbnail);
  const double now = since.match >= kGoodMatch ? std::abs(since.dx_px) / frame.thumbnail.width / seconds : speed_;
  const double weight = std::min(1.0, seconds / kSpeedSmoothing_s);
  speed_ += weight * (now - speed_);
  frame_interval_s_ = seconds;
  if (speed_ >= kIdleSpeed) slow_since_ns_ = frame.time_ns;
}

// Two frames in a row show what the first one showed, passing by as everything does. Of the angle only that it is time
// to look: near things, which pass faster than the camera turns, and a guessed field of view can more than double it.
bool FrameChooser::came_round(const GreyImage& thumbnail) {
  if (guidance().covered_rad < kLookForFirstFrom_rad) return false;
  const Shift now = estimate_shift(*first_, thumbnail);
  const std::optional<Shift> before = std::exchange(first_seen_, now);
  if (!before || before->match < kGoodMatch || now.match < kSamePlace) return false;
  const double passed = direction_ * (before->dx_px - now.dx_px) / thumbnail.width;
  return passed > -kHandShake && std::abs(now.dx_px) < kBeside * thumbnail.width;
}

bool FrameChooser::shows_the_first_place(const GreyImage& thumbnail) const {
  const Shift shift = estimate_shift(*first_, thumbnail);
  const double moved_rad = std::hypot(shift.dx_px, shift.dy_px) / thumbnail.width * options_.fov_rad;
  return shift.match >= kGoodMatch && moved_rad < kStandsStill_rad;
}

bool FrameChooser::stands_still() const { return !moved_ && still_frames_ >= kStillFrames; }

Guidance FrameChooser::guidance() const {
  const double radians = options_.fov_rad;  // per share of the width, on average over the picture
  Guidance guidance;
  guidance.covered_rad = turned_ * radians;
  guidance.speed_rad_s = speed_ * radians;
  guidance.tilt_px = tilt_;
  guidance.brightness = brightness_;
  guidance.frames_chosen = frames_;
  const double wanted = 1 - options_.overlap;
  const bool outruns_camera = frame_interval_s_ > 0 && speed_ * frame_interval_s_ > wanted;
  const double height = first_ ? first_->height : 1;
  if (full_) {
    guidance.advice = Advice::done;
  } else if (frames_ > 0 && brightness_ < kDark) {
    guidance.advice = Advice::too_dark;
  } else if (speed_ > blur_limit_ || outruns_camera) {
    guidance.advice = Advice::slower;
  } else if (std::abs(tilt_) > kMaxTilt * height) {
    guidance.advice = Advice::level;
  } else if (turned_ - turned_before_ < kTurnBack) {
    guidance.advice = Advice::turn_back;
  } else if (last_ns_ - slow_since_ns_ > kIdlePatience_ns) {
    guidance.advice = Advice::faster;
  }
  return guidance;
}

}  // namespace ldp
