#include "drivers/v4l2/v4l2_controls.h"

#include <linux/videodev2.h>

#include "drivers/v4l2/v4l2_ioctl.h"

namespace ldp::v4l2 {
namespace {

std::optional<int32_t> get(int fd, uint32_t id) {
  v4l2_control control{id, 0};
  if (call(fd, VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
  return control.value;
}

bool write(int fd, uint32_t id, int32_t value) {
  v4l2_control control{id, value};
  return call(fd, VIDIOC_S_CTRL, &control) == 0;
}

}  // namespace

bool AutomaticControls::lock(int fd) {
  const bool by_lock = set(fd, V4L2_CID_3A_LOCK, V4L2_LOCK_EXPOSURE | V4L2_LOCK_WHITE_BALANCE | V4L2_LOCK_FOCUS);
  // Going manual keeps the present value only if it is read before and written after.
  const auto exposure = get(fd, V4L2_CID_EXPOSURE_ABSOLUTE);
  const auto gain = get(fd, V4L2_CID_GAIN);
  const auto temperature = get(fd, V4L2_CID_WHITE_BALANCE_TEMPERATURE);
  const bool by_mode = set(fd, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
  if (by_mode && exposure) write(fd, V4L2_CID_EXPOSURE_ABSOLUTE, *exposure);
  if (set(fd, V4L2_CID_AUTOGAIN, 0) && gain) write(fd, V4L2_CID_GAIN, *gain);
  if (set(fd, V4L2_CID_AUTO_WHITE_BALANCE, 0) && temperature) {
    write(fd, V4L2_CID_WHITE_BALANCE_TEMPERATURE, *temperature);
  }
  set(fd, V4L2_CID_FOCUS_AUTO, 0);
  return by_lock || by_mode;
}

void AutomaticControls::unlock(int fd) {
  for (const auto& [id, value] : before_) write(fd, id, value);
  before_.clear();
}

bool AutomaticControls::set(int fd, uint32_t id, int32_t value) {
  const auto before = get(fd, id);
  if (!before || !write(fd, id, value)) return false;
  before_.try_emplace(id, *before);
  return true;
}

}  // namespace ldp::v4l2
