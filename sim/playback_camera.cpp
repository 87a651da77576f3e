#include "sim/playback_camera.h"

#include <algorithm>
#include <utility>

#include "drivers/interface/clocks.h"

namespace ldp {

PlaybackCamera::Timing PlaybackCamera::timing_from(const Url& url) {
  Timing timing;
  timing.fps = url.number("fps", timing.fps, {0.1, 1000});
  timing.hold = url.flag("hold", timing.hold);
  timing.lost_after = url.integer("lost_after", -1, {0, 1e9});
  timing.stall_after = url.integer("stall_after", -1, {0, 1e9});
  return timing;
}

PlaybackCamera::PlaybackCamera(const Timing& timing, Playback playback)
    : playback_(std::move(playback)), timing_(timing) {}

CameraMode PlaybackCamera::mode() const {
  CameraMode mode;
  mode.format = playback_.format;
  mode.width = playback_.width;
  mode.height = playback_.height;
  mode.fps = timing_.fps;
  return mode;
}

bool PlaybackCamera::prepare(const std::function<bool()>& give_up) {
  return !playback_.prepare || playback_.prepare(give_up);
}

void PlaybackCamera::start() {
  prepare([] { return false; });
  next_ = 0;
  const auto interval_ns = static_cast<int64_t>(1e9 / timing_.fps);
  ticker_.start_at(monotonic_now_ns() + interval_ns, interval_ns);
}

std::optional<CameraFrame> PlaybackCamera::read() {
  if (ticker_.take_expirations() == 0) return std::nullopt;
  if (timing_.stall_after >= 0 && next_ >= timing_.stall_after) return std::nullopt;
  if (timing_.lost_after >= 0 && next_ >= timing_.lost_after) throw CameraLost("the simulated camera was unplugged");
  if (next_ >= playback_.count && !timing_.hold) throw CameraLost("the simulated camera has no more frames");
  CameraFrame frame = playback_.frame(std::min(next_, playback_.count - 1));
  frame.sequence = next_++;
  frame.time_ns = monotonic_now_ns();
  return frame;
}

}  // namespace ldp
