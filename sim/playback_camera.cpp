#include "playback_camera.h"

#include <algorithm>
#include <utility>

#include "clocks.h"

namespace ldp {

PlaybackCamera::PlaybackCamera(const Url& url, Playback playback)
    : playback_(std::move(playback)),
      fps_(url.number("fps", 30, {0.1, 1000})),
      hold_(url.flag("hold", true)),
      lost_after_(url.integer("lost_after", -1, {0, 1e9})),
      stall_after_(url.integer("stall_after", -1, {0, 1e9})) {}

CameraMode PlaybackCamera::mode() const {
  CameraMode mode;
  mode.format = playback_.format;
  mode.width = playback_.width;
  mode.height = playback_.height;
  mode.fps = fps_;
  return mode;
}

void PlaybackCamera::start() {
  next_ = 0;
  const auto interval_ns = static_cast<int64_t>(1e9 / fps_);
  ticker_.start_at(monotonic_now_ns() + interval_ns, interval_ns);
}

std::optional<CameraFrame> PlaybackCamera::read() {
  if (ticker_.take_expirations() == 0) return std::nullopt;
  if (stall_after_ >= 0 && next_ >= stall_after_) return std::nullopt;
  if (lost_after_ >= 0 && next_ >= lost_after_) throw CameraLost("the simulated camera was unplugged");
  if (next_ >= playback_.count && !hold_) throw CameraLost("the simulated camera has no more frames");
  CameraFrame frame = playback_.frame(std::min(next_, playback_.count - 1));
  frame.sequence = next_++;
  frame.time_ns = monotonic_now_ns();
  return frame;
}

}  // namespace ldp
