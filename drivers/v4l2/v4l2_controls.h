// Exposure, gain, white balance and focus of a V4L2 device, held for a sweep and let go after it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace ldp::v4l2 {

// Freezes what cameras adjust by themselves and remembers how it was.
class AutomaticControls {
 public:
  // Whether exposure is held: not every device can.
  bool lock(int fd);
  void unlock(int fd);

 private:
  bool set(int fd, uint32_t id, int32_t value);

  std::map<uint32_t, int32_t> before_;
};

}  // namespace ldp::v4l2
