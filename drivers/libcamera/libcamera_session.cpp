#include "drivers/libcamera/libcamera_session.h"

#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "drivers/interface/errors.h"

namespace ldp {

CompletedRequests::CompletedRequests() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!event_.is_open()) throw_errno("cannot make an event descriptor");
}

void CompletedRequests::put(libcamera::Request* request) {
  {
    const std::scoped_lock lock(mutex_);
    requests_.push_back(request);
  }
  raise();
}

void CompletedRequests::disconnect() {
  {
    const std::scoped_lock lock(mutex_);
    disconnected_ = true;
  }
  raise();
}

libcamera::Request* CompletedRequests::take() {
  const std::scoped_lock lock(mutex_);
  if (requests_.empty()) {
    uint64_t count = 0;
    if (!disconnected_) [[maybe_unused]]
      const ssize_t got = ::read(event_.get(), &count, sizeof count);
    return nullptr;
  }
  libcamera::Request* const request = requests_.front();
  requests_.pop_front();
  return request;
}

bool CompletedRequests::disconnected() const {
  const std::scoped_lock lock(mutex_);
  return disconnected_;
}

void CompletedRequests::clear() {
  const std::scoped_lock lock(mutex_);
  requests_.clear();
}

void CompletedRequests::raise() {
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t put = ::write(event_.get(), &one, sizeof one);
}

MappedBuffer::MappedBuffer(const libcamera::FrameBuffer& buffer) {
  try {
    for (const auto& plane : buffer.planes()) planes_.push_back(map(plane));
  } catch (...) {
    unmap();
    throw;
  }
}

FramePlane MappedBuffer::map(const libcamera::FrameBuffer::Plane& plane) {
  const off_t end = ::lseek(plane.fd.get(), 0, SEEK_END);
  const size_t offset = plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
  const size_t size = std::max(end > 0 ? static_cast<size_t>(end) : 0, offset + plane.length);
  auto [area, fresh] = areas_.try_emplace(plane.fd.get(), Area{MAP_FAILED, size});
  if (fresh) area->second.address = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, plane.fd.get(), 0);
  if (area->second.address == MAP_FAILED) throw_errno("cannot map a camera buffer");
  return {static_cast<const uint8_t*>(area->second.address) + offset, plane.length, 0};
}

void MappedBuffer::unmap() {
  for (const auto& [fd, area] : areas_) {
    if (area.address != MAP_FAILED) ::munmap(area.address, area.size);
  }
}

LibcameraSession::LibcameraSession() {
  ::setenv("LIBCAMERA_LOG_LEVELS", "WARN", 0);  // what it says of itself belongs in nobody's log
  if (manager.start() != 0) throw std::runtime_error("libcamera cannot start; are the camera's device files readable?");
}

LibcameraSession::~LibcameraSession() {
  stop();
  requests.clear();
  mapped.clear();
  allocator.reset();
  configuration.reset();
  if (camera) camera->release();
  camera.reset();
  manager.stop();
}

void LibcameraSession::stop() {
  if (!std::exchange(running, false)) return;
  camera->stop();  // completes what is queued as cancelled, before it returns
  completed.clear();
}

void LibcameraSession::give_back(libcamera::Request* request, int its_generation) {
  if (!running || its_generation != generation) return;
  request->reuse(libcamera::Request::ReuseBuffers);
  request->controls() = std::exchange(pending_controls, libcamera::ControlList(libcamera::controls::controls));
  camera->queueRequest(request);
}

}  // namespace ldp
