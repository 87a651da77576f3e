// libcamera's objects of one camera in use: requests between its thread and ours, mapped buffers, and the order in
// which everything must go.
#pragma once

#include <libcamera/libcamera.h>

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "drivers/interface/camera.h"
#include "drivers/interface/unique_fd.h"

namespace ldp {

// What the callback thread and the reader share. The descriptor is readable while requests wait, and for good once the
// camera was disconnected. Throws std::system_error where there are no descriptors left.
class CompletedRequests {
 public:
  CompletedRequests();

  int fd() const { return event_.get(); }

  void put(libcamera::Request* request);
  void disconnect();
  libcamera::Request* take();  // nullptr = none waits
  bool disconnected() const;
  void clear();

 private:
  void raise();

  UniqueFd event_;
  mutable std::mutex mutex_;
  std::deque<libcamera::Request*> requests_;
  bool disconnected_ = false;
};

// A whole buffer's memory, mapped once; its planes lie in it at their offsets.
class MappedBuffer {
 public:
  explicit MappedBuffer(const libcamera::FrameBuffer& buffer);
  MappedBuffer(const MappedBuffer&) = delete;
  MappedBuffer& operator=(const MappedBuffer&) = delete;
  ~MappedBuffer() { unmap(); }

  const std::vector<FramePlane>& planes() const { return planes_; }

 private:
  struct Area {
    void* address;
    size_t size;
  };

  FramePlane map(const libcamera::FrameBuffer::Plane& plane);
  void unmap();

  std::map<int, Area> areas_;
  std::vector<FramePlane> planes_;
};

// Everything that must go in the right order, and that frames keep alive.
struct LibcameraSession {
  libcamera::CameraManager manager;
  std::shared_ptr<libcamera::Camera> camera;
  std::unique_ptr<libcamera::CameraConfiguration> configuration;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator;
  std::map<const libcamera::FrameBuffer*, std::unique_ptr<MappedBuffer>> mapped;
  std::vector<std::unique_ptr<libcamera::Request>> requests;
  int generation = 0;  // of the requests; frames of an earlier one may still be held, and give nothing back
  CompletedRequests completed;
  libcamera::ControlList pending_controls;  // for the next request
  bool running = false;

  // Throws std::runtime_error where libcamera cannot start.
  LibcameraSession();
  LibcameraSession(const LibcameraSession&) = delete;
  LibcameraSession& operator=(const LibcameraSession&) = delete;
  ~LibcameraSession();

  void stop();
  void give_back(libcamera::Request* request, int its_generation);
};

}  // namespace ldp
