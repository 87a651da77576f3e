// The one way to the kernel: a test puts a device of its own in its place.
#pragma once

namespace ldp::v4l2 {

// ioctl, repeated where a signal interrupts it. Where it gives anything but 0, errno says why.
int call(int fd, unsigned long request, void* argument);

}  // namespace ldp::v4l2
