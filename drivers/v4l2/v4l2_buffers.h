// Memory-mapped buffers of a V4L2 stream, of the single and the multi-planar interface alike.
#pragma once

#include <linux/videodev2.h>
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/interface/errors.h"
#include "drivers/interface/unique_fd.h"
#include "drivers/v4l2/v4l2_ioctl.h"

namespace ldp::v4l2 {

// Throws std::system_error where a buffer cannot be mapped.
struct Mapping {
  uint8_t* bytes = nullptr;
  size_t size = 0;
  Mapping(int fd, size_t length, uint32_t offset) : size(length) {
    void* const address = ::mmap(nullptr, length, PROT_READ, MAP_SHARED, fd, static_cast<off_t>(offset));
    if (address == MAP_FAILED) throw_errno("cannot map a camera buffer");
    bytes = static_cast<uint8_t*>(address);
  }
  Mapping(Mapping&& other) noexcept : bytes(std::exchange(other.bytes, nullptr)), size(other.size) {}
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() {
    if (bytes != nullptr) ::munmap(bytes, size);
  }
};

// A v4l2_buffer with room for the one memory plane that both APIs (single and multi-planar) need here.
struct Buffer {
  v4l2_buffer buffer{};
  v4l2_plane plane{};

  Buffer(uint32_t type, uint32_t index) {
    buffer.type = type;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
  }
  bool is_multiplanar() const { return V4L2_TYPE_IS_MULTIPLANAR(buffer.type); }
  int call(int fd, unsigned long request) {
    if (is_multiplanar()) {
      buffer.m.planes = &plane;
      buffer.length = 1;
    }
    return v4l2::call(fd, request, &buffer);
  }
  size_t length() const { return is_multiplanar() ? plane.length : buffer.length; }
  uint32_t offset() const { return is_multiplanar() ? plane.m.mem_offset : buffer.m.offset; }
  size_t bytes_used() const { return is_multiplanar() ? plane.bytesused : buffer.bytesused; }
  size_t data_offset() const { return is_multiplanar() ? plane.data_offset : 0; }
};

// What frames keep alive: the device and its mapped buffers of one start..stop.
struct Stream {
  UniqueFd fd;
  uint32_t type = 0;
  std::vector<Mapping> mappings;
  bool running = false;

  void give_back(uint32_t index) const {
    if (!running) return;
    Buffer buffer(type, index);
    buffer.call(fd.get(), VIDIOC_QBUF);  // a failure shows at the next DQBUF
  }
};

}  // namespace ldp::v4l2
