#include "device/service/sweep_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <utility>

#include "core/geometry/degrees.h"
#include "device/capture/frame_pixels.h"
#include "device/capture/log.h"
#include "device/service/session_tuning.h"
#include "drivers/interface/clocks.h"

namespace ldp {
namespace {

ChooserOptions chooser_options(const Config& config) {
  ChooserOptions options;
  options.overlap = config.overlap;
  options.max_frames = config.max_frames;
  options.fov_rad = config.fov_degrees > 0 ? config.fov_degrees * kRadiansPerDegree : kUsualFov_rad;
  return options;
}

int64_t ns_from(double seconds) { return static_cast<int64_t>(seconds * 1e9); }

}  // namespace

SweepRun::SweepRun(const Config& config, std::unique_ptr<CameraDevice> camera, std::filesystem::path folder,
                   FrameWriter& writer)
    : config_(config),
      camera_(std::move(camera)),
      folder_(std::move(folder)),
      writer_(writer),
      chooser_(chooser_options(config)) {
  const CameraMode mode = camera_->mode();
  settle_s_ = mode.settle_s;
  record_.device = config.device_name;
  record_.camera = camera_->name();
  record_.width = mode.width;
  record_.height = mode.height;
  record_.pixel_format = name_of(mode.format);
  record_.arm_length_m = config.arm_length_m;
  if (config.fov_degrees > 0) record_.fov_rad = config.fov_degrees * kRadiansPerDegree;
  record_.begin_utc_ns = utc_now_ns();
  record_.clock_synchronized = utc_is_synchronized();
  record_.begin_ns = monotonic_now_ns();
  camera_->start();
  start_ns_ = last_frame_ns_ = monotonic_now_ns();
}

void SweepRun::read_frame() {
  auto frame = camera_->read();
  if (!frame) return;
  last_frame_ns_ = monotonic_now_ns();
  try {
    take(std::move(*frame));
  } catch (const std::runtime_error& error) {
    log_warning(std::string("a frame was skipped: ") + error.what());  // a JPEG damaged on its way
  } catch (const std::bad_alloc&) {
    log_warning("a frame was skipped: not enough memory");
  }
}

void SweepRun::take(CameraFrame frame) {
  OfferedFrame offered{thumbnail(frame), 0, frame.time_ns, frame.exposure_s};
  if (!settled(frame, mean_brightness(offered.thumbnail))) return;
  offered.sharpness = sharpness(frame);
  if (!is_of_the_sweep(stored_size(frame))) throw std::runtime_error("its size is another");
  if (first_thumbnail_.empty()) first_thumbnail_ = offered.thumbnail;
  // A folder's JPEG is shrunk in other steps than its other pictures.
  if (offered.thumbnail.width != first_thumbnail_.width || offered.thumbnail.height != first_thumbnail_.height) {
    throw std::runtime_error("its kind is another");
  }
  const Verdict verdict = chooser_.offer(offered);
  if (verdict.store_held && held_) store(*held_);
  if (verdict.store_held || verdict.store_this) held_.reset();
  if (verdict.store_this) store(frame);
  if (verdict.hold_this) held_ = std::move(frame);
}

// A JPEG whose header was damaged says another size than it has, the first one of a sweep as well: that of the sweep is
// the camera's, lying (a folder's photograph that is turned when it is read) or standing, or what several in a row
// have.
bool SweepRun::is_of_the_sweep(ImageSize size) {
  if (size_) return size == *size_;
  alike_ = size == last_size_ ? alike_ + 1 : 1;
  last_size_ = size;
  const ImageSize own{record_.width, record_.height}, turned{record_.height, record_.width};
  const bool is_own = size == own || size == turned;
  if (!is_own && alike_ < kAlikeFrames) return false;
  if (!is_own) record_.width = size.width, record_.height = size.height;
  size_ = size;
  return true;
}

// Lets automatic exposure come to rest, then locks it for the rest of the sweep.
bool SweepRun::settled(const CameraFrame& frame, double brightness) {
  if (settled_) return true;
  if (first_frame_time_ns_ == 0) first_frame_time_ns_ = frame.time_ns;
  const double seconds = static_cast<double>(frame.time_ns - first_frame_time_ns_) * 1e-9;
  steady_frames_ = std::abs(brightness - last_brightness_) < kSteadyBrightness ? steady_frames_ + 1 : 0;
  last_brightness_ = brightness;
  const bool rests = seconds >= settle_s_ && (settle_s_ == 0 || steady_frames_ >= kSteadyFrames);
  settled_ = rests || seconds >= settle_s_ * kMaxSettleFactor;
  if (settled_) record_.exposure_locked = camera_->lock_exposure(true);
  return settled_;
}

void SweepRun::store(const CameraFrame& frame) {
  char file[32];
  std::snprintf(file, sizeof file, "frame_%03d.jpg", chosen());
  std::vector<uint8_t> jpeg = jpeg_from(frame);  // may fail, and is not recorded then
  record_.frames.push_back({file, frame.time_ns, frame.sequence, frame.exposure_s, frame.gain});
  writer_.put({folder_, file, std::move(jpeg), capture_json(record_)});
}

std::optional<Guidance> SweepRun::next_guidance(int64_t now_ns) {
  if (now_ns < next_guidance_ns_) return std::nullopt;
  next_guidance_ns_ = now_ns + kGuidanceInterval_ns;
  return guidance();
}

void SweepRun::end(const Reason& reason, bool complete) {
  end_ns_ = monotonic_now_ns();
  end_reason_ = reason;
  camera_->lock_exposure(false);
  camera_->stop();
  try {
    if (chooser_.finish() && held_) store(*held_);
  } catch (const std::exception& error) {
    log_warning(std::string("the last frame was skipped: ") + error.what());
  }
  held_.reset();
  record_.end_ns = monotonic_now_ns();
  record_.complete = complete;
  record_.end_reason = text_of(reason);
  writer_.put({folder_, "", {}, capture_json(record_)});
  stores_ = true;
  camera_.reset();
}

void SweepRun::note(const WriteOutcome& outcome) {
  if (!outcome.error.empty()) {
    if (storage_problem_.why == Why::none)
      storage_problem_ = {Why::storage_failed, "cannot store: " + outcome.error, outcome.code};
  } else if (!outcome.file.empty()) {
    ++frames_stored_;
  }
}

Reason SweepRun::too_few_frames() const {
  ShortSweep sweep;
  sweep.frames = frames_stored_;
  sweep.frames_needed = config_.min_frames;
  sweep.end = end_reason_;
  sweep.storage_problem = storage_problem_;
  sweep.seconds = static_cast<double>(end_ns_ - start_ns_) * 1e-9;
  sweep.covered_rad = guidance().covered_rad;
  sweep.mode = mode_of(config_);
  return ldp::too_few_frames(sweep);
}

bool SweepRun::full(int64_t now_ns) const {
  return chooser_.full() || now_ns - start_ns_ >= ns_from(config_.max_seconds);
}

bool SweepRun::stalled(int64_t now_ns) const { return now_ns - last_frame_ns_ >= ns_from(config_.lost_after_seconds); }

int64_t SweepRun::deadline_ns() const {
  return std::min(start_ns_ + ns_from(config_.max_seconds), last_frame_ns_ + ns_from(config_.lost_after_seconds));
}

}  // namespace ldp
