#include "drivers/v4l2/v4l2_ioctl.h"

#include <sys/ioctl.h>

#include <cerrno>

namespace ldp::v4l2 {

int call(int fd, unsigned long request, void* argument) {
  int result = 0;
  do {
    result = ::ioctl(fd, request, argument);
  } while (result != 0 && errno == EINTR);
  return result;
}

}  // namespace ldp::v4l2
