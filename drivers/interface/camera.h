// A camera that streams: readable through one file descriptor, chosen by URL.
//
//   libcamera:0            libcamera:NAME          camera by index or by libcamera's id
//   v4l2:/dev/video0       ?width= height= fps= format=mjpeg|yuyv|nv12   nearest mode that the device offers
//   folder:DIR             ?fps=30 hold=yes        the .jpg and .png files of a folder in name order, one per tick
//   scene:NAME             ?fps=30 frames=20 ...   a synthetic scene, rendered
//
// A poll loop waits for `fd()` to become readable while the camera is started, then calls `read()`; what was not read
// keeps it readable. Nothing here blocks longer than opening and starting the device takes; nothing calls back.
// A new back-end is a row of drivers/hardware.cpp, or of sim/devices.cpp without hardware (CONTRIBUTING.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace ldp {

enum class PixelFormat : uint8_t {
  mjpeg,  // one plane: a whole JPEG file, stride 0
  yuyv,   // one plane, 2 bytes a pixel
  nv12,   // two planes: luma; interleaved chroma at half resolution
  rgb24,  // one plane, bytes R G B
  bgr24,  // one plane, bytes B G R
};

const char* name_of(PixelFormat format);

struct CameraMode {
  PixelFormat format = PixelFormat::mjpeg;
  int width = 0, height = 0;  // pixels; of a frame when it differs (folder of unlike images), the frame's own
  double fps = 0;             // 0 = unknown
  double settle_s = 0;        // that automatic exposure needs after `start`; 0 = every frame is good
};

struct FramePlane {
  const uint8_t* bytes = nullptr;
  size_t size = 0;  // bytes that may be read
  int stride = 0;   // bytes from row to row
};

// One picture, still in the camera's buffer. The buffer goes back to the camera when the last copy of `lease` is
// dropped, which is allowed after the camera was stopped or destroyed, and from the thread that reads the camera only.
struct CameraFrame {
  int64_t sequence = 0;  // counts the camera's frames, dropped ones included, where the device tells
  int64_t time_ns = 0;   // CLOCK_MONOTONIC, start of exposure or the nearest the device knows
  PixelFormat format = PixelFormat::mjpeg;
  int width = 0, height = 0;
  std::vector<FramePlane> planes;
  std::optional<double> exposure_s;
  std::optional<double> gain;
  std::shared_ptr<const void> lease;
};

// The camera went away or broke: what() is one line for the user. The object is of no further use.
struct CameraLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  virtual std::string name() const = 0;  // what the device calls itself, for capture.json
  virtual CameraMode mode() const = 0;
  // What takes long before the first `start`, where anything does; goes on where it was left. False: `give_up` said
  // true, and it is not done. `start` does what is left of it, however long that takes.
  virtual bool prepare(const std::function<bool()>& /*give_up*/) { return true; }
  virtual void start() = 0;                       // streams until `stop`; throws CameraLost
  virtual void stop() = 0;                        // never throws; frames not yet read are dropped
  virtual int fd() const = 0;                     // the same one for the object's life; poll it only while started
  virtual std::optional<CameraFrame> read() = 0;  // oldest finished frame, none if none is ready; throws CameraLost

  // Freezes exposure, gain and white balance where they are now, or lets them run again. False if the device cannot.
  virtual bool lock_exposure(bool locked) = 0;
};

}  // namespace ldp
