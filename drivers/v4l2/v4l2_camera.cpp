// Cameras of the Linux kernel (USB webcams, capture cards, simple sensors) through V4L2, memory-mapped streaming.
// https://docs.kernel.org/userspace-api/media/v4l/mmap.html is the reference for the order of the calls.
#include <fcntl.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "drivers/backends.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"
#include "drivers/v4l2/v4l2_buffers.h"
#include "drivers/v4l2/v4l2_controls.h"
#include "drivers/v4l2/v4l2_ioctl.h"
#include "drivers/v4l2/v4l2_offers.h"
#include "drivers/v4l2_modes.h"

namespace ldp {

using namespace v4l2;

namespace {

constexpr uint32_t kBuffers = 6;  // one being filled, some waiting, two held as candidates by the reader
constexpr int kErrorsInARow = 5;  // of DQBUF before the camera counts as broken

[[noreturn]] void cannot_open(const std::string& path, int error) {
  const std::string attempted = "cannot open the camera '" + path + "'";
  if (error == ENOENT) throw AdvisedError(attempted, error, "'ls /dev/video*' lists those connected");
  if (error == EACCES) throw AdvisedError(attempted, error, "join its group, mostly 'video'");
  throw_errno(attempted, error);
}

class V4l2Camera final : public CameraDevice {
 public:
  explicit V4l2Camera(const Url& url) : path_(url.path()), stream_(std::make_shared<Stream>()) {
    const ModeWish wish = wish_from(url);
    stream_->fd.reset(::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    if (fd() < 0) cannot_open(path_, errno);
    query_capabilities();
    set_mode(wish);
  }
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;
  ~V4l2Camera() override {
    stop();
    controls_.unlock(fd());
  }

  std::string name() const override { return name_; }
  CameraMode mode() const override { return mode_; }
  int fd() const override { return stream_->fd.get(); }

  void start() override {
    request_buffers();
    for (uint32_t index = 0; index < stream_->mappings.size(); ++index) {
      Buffer buffer(type_, index);
      if (buffer.call(fd(), VIDIOC_QBUF) != 0) lose("cannot queue a buffer");
    }
    int type = static_cast<int>(type_);
    if (call(fd(), VIDIOC_STREAMON, &type) != 0) lose("cannot start streaming");
    stream_->running = true;
    errors_ = 0;
  }

  void stop() override {
    if (!std::exchange(stream_->running, false)) return;
    int type = static_cast<int>(type_);
    call(fd(), VIDIOC_STREAMOFF, &type);
  }

  std::optional<CameraFrame> read() override {
    for (uint32_t attempt = 0; attempt < kBuffers && stream_->running; ++attempt) {
      Buffer buffer(type_, 0);
      if (buffer.call(fd(), VIDIOC_DQBUF) != 0) {
        if (errno == EAGAIN) return std::nullopt;
        if (errno != EIO || ++errors_ >= kErrorsInARow) lose("cannot read a frame");
        continue;
      }
      if (auto frame = frame_from(buffer)) {
        errors_ = 0;
        return frame;
      }
      stream_->give_back(buffer.buffer.index);  // damaged on the wire
    }
    return std::nullopt;
  }

  bool lock_exposure(bool locked) override {
    if (locked) return controls_.lock(fd());
    controls_.unlock(fd());
    return true;
  }

 private:
  [[noreturn]] void lose(const std::string& what) {
    const int error = errno;
    const bool gone = error == ENODEV || error == ENXIO;
    throw CameraLost("camera '" + path_ + "': " + (gone ? "it was disconnected" : what + ": " + std::strerror(error)));
  }

  void query_capabilities() {
    v4l2_capability capability{};
    if (call(fd(), VIDIOC_QUERYCAP, &capability) != 0) throw_errno("'" + path_ + "' is not a V4L2 device");
    const uint32_t can =
        (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
    name_ = reinterpret_cast<const char*>(capability.card);
    if ((can & V4L2_CAP_VIDEO_CAPTURE) != 0) {
      type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    } else if ((can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0) {
      type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
    } else {
      throw std::runtime_error("'" + path_ + "' (" + name_ + ") does not capture video; try another /dev/video number");
    }
    if ((can & V4L2_CAP_STREAMING) == 0) {
      throw std::runtime_error("'" + path_ + "' (" + name_ + ") cannot stream into mapped memory");
    }
    stream_->type = type_;
  }

  void set_mode(const ModeWish& wish) {
    const std::vector<Offer> offers = offers_of(fd(), type_, wish);
    std::vector<CameraMode> modes;
    for (const Offer& offer : offers) modes.push_back(offer.mode);
    const auto chosen = choose_mode(modes, wish);
    if (!chosen) {
      throw std::runtime_error("'" + path_ + "' (" + name_ + ") offers " +
                               (wish.format ? "no mode of that format" : "none of MJPEG, YUYV, NV12, RGB"));
    }
    for (const Offer& offer : offers) {
      if (offer.mode.format == chosen->format && offer.mode.width == chosen->width &&
          offer.mode.height == chosen->height) {
        apply(offer);
        break;
      }
    }
    set_rate(wish.fps);
  }

  // The driver may still adjust; what it answers is what holds.
  void apply(const Offer& offer) {
    v4l2_format format{};
    format.type = type_;
    const bool multiplanar = V4L2_TYPE_IS_MULTIPLANAR(type_);
    if (multiplanar) {
      format.fmt.pix_mp.width = static_cast<uint32_t>(offer.mode.width);
      format.fmt.pix_mp.height = static_cast<uint32_t>(offer.mode.height);
      format.fmt.pix_mp.pixelformat = offer.code;
      format.fmt.pix_mp.num_planes = 1;
    } else {
      format.fmt.pix.width = static_cast<uint32_t>(offer.mode.width);
      format.fmt.pix.height = static_cast<uint32_t>(offer.mode.height);
      format.fmt.pix.pixelformat = offer.code;
    }
    if (call(fd(), VIDIOC_S_FMT, &format) != 0) throw_errno("cannot set the video mode of '" + path_ + "'");
    mode_ = offer.mode;
    const auto& mp = format.fmt.pix_mp;
    const auto& sp = format.fmt.pix;
    mode_.width = static_cast<int>(multiplanar ? mp.width : sp.width);
    mode_.height = static_cast<int>(multiplanar ? mp.height : sp.height);
    stride_ = static_cast<int>(multiplanar ? mp.plane_fmt[0].bytesperline : sp.bytesperline);
    const auto answered = format_from(multiplanar ? mp.pixelformat : sp.pixelformat);
    if (!answered)
      throw std::runtime_error("'" + path_ + "' (" + name_ + ") insists on a pixel format that is not known here");
    mode_.format = *answered;
    stride_ = std::max(stride_, least_stride());  // some drivers tell none
  }

  int least_stride() const {
    switch (mode_.format) {
      case PixelFormat::mjpeg:
        return 0;
      case PixelFormat::nv12:
        return mode_.width;
      case PixelFormat::yuyv:
        return 2 * mode_.width;
      case PixelFormat::rgb24:
      case PixelFormat::bgr24:
        break;
    }
    return 3 * mode_.width;
  }

  void set_rate(double fps) {
    v4l2_streamparm parameters{};
    parameters.type = type_;
    parameters.parm.capture.timeperframe = {1000, static_cast<uint32_t>(std::lround(fps * 1000))};
    if (call(fd(), VIDIOC_S_PARM, &parameters) != 0) return;  // no choice of rate: the mode's own holds
    const double answered = fps_from(parameters.parm.capture.timeperframe);
    if (answered > 0) mode_.fps = answered;
  }

  void request_buffers() {
    stop();
    auto fresh = std::make_shared<Stream>();  // frames of an earlier start may still hold the old mappings
    fresh->type = type_;
    v4l2_requestbuffers request{};
    request.type = type_;
    request.memory = V4L2_MEMORY_MMAP;
    request.count = 0;
    if (stream_.use_count() == 1) stream_->mappings.clear();
    call(fd(), VIDIOC_REQBUFS, &request);
    request.count = kBuffers;
    if (call(fd(), VIDIOC_REQBUFS, &request) != 0) lose("cannot get buffers");
    if (request.count < 2) throw CameraLost("camera '" + path_ + "': too little memory for its buffers");
    for (uint32_t index = 0; index < request.count; ++index) {
      Buffer buffer(type_, index);
      if (buffer.call(fd(), VIDIOC_QUERYBUF) != 0) lose("cannot query a buffer");
      fresh->mappings.emplace_back(fd(), buffer.length(), buffer.offset());
    }
    fresh->fd = std::move(stream_->fd);
    stream_ = std::move(fresh);
  }

  std::optional<CameraFrame> frame_from(const Buffer& buffer) const {
    const uint32_t index = buffer.buffer.index;
    const Mapping& mapping = stream_->mappings[index];
    const size_t skip = buffer.data_offset();
    const size_t used = std::min(buffer.bytes_used(), mapping.size);
    if ((buffer.buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 || used <= skip) return std::nullopt;
    CameraFrame frame;
    frame.planes = planes_of(mapping.bytes + skip, used - skip);
    if (frame.planes.empty()) return std::nullopt;
    frame.sequence = buffer.buffer.sequence;
    const bool monotonic = (buffer.buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    const timeval& time = buffer.buffer.timestamp;
    frame.time_ns =
        monotonic ? int64_t{time.tv_sec} * 1'000'000'000 + int64_t{time.tv_usec} * 1000 : monotonic_now_ns();
    frame.format = mode_.format;
    frame.width = mode_.width;
    frame.height = mode_.height;
    frame.lease = std::shared_ptr<const void>(mapping.bytes,
                                              [stream = stream_, index](const void*) { stream->give_back(index); });
    return frame;
  }

  // Empty if the frame is cut short.
  std::vector<FramePlane> planes_of(const uint8_t* bytes, size_t size) const {
    const size_t height = static_cast<size_t>(mode_.height), stride = static_cast<size_t>(stride_);
    switch (mode_.format) {
      case PixelFormat::mjpeg:
        if (size < 4 || bytes[0] != 0xFF || bytes[1] != 0xD8) return {};
        return {{bytes, size, 0}};
      case PixelFormat::nv12:
        if (size < stride * height * 3 / 2) return {};
        return {{bytes, stride * height, stride_}, {bytes + stride * height, stride * height / 2, stride_}};
      case PixelFormat::yuyv:
      case PixelFormat::rgb24:
      case PixelFormat::bgr24:
        break;
    }
    if (size < stride * height) return {};
    return {{bytes, size, stride_}};
  }

  std::string path_, name_;
  uint32_t type_ = 0;
  CameraMode mode_;
  int stride_ = 0;
  int errors_ = 0;
  std::shared_ptr<Stream> stream_;
  AutomaticControls controls_;
};

}  // namespace

void check_v4l2_camera(const Url& url) { wish_from(url); }

std::unique_ptr<CameraDevice> open_v4l2_camera(const Url& url) { return std::make_unique<V4l2Camera>(url); }

}  // namespace ldp
