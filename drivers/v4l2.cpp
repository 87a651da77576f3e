// Cameras of the Linux kernel (USB webcams, capture cards, simple sensors) through V4L2, memory-mapped streaming.
// https://docs.kernel.org/userspace-api/media/v4l/mmap.html is the reference for the order of the calls.
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "drivers/backends.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"
#include "drivers/interface/unique_fd.h"
#include "drivers/v4l2_modes.h"

namespace ldp {
namespace {

constexpr uint32_t kBuffers = 6;   // one being filled, some waiting, two held as candidates by the reader
constexpr int kErrorsInARow = 5;   // of DQBUF before the camera counts as broken
constexpr double kSettle_s = 0.5;  // automatic exposure after the start of the stream

int call(int fd, unsigned long request, void* argument) {
  int result = 0;
  do {
    result = ::ioctl(fd, request, argument);
  } while (result != 0 && errno == EINTR);
  return result;
}

struct FourCc {
  uint32_t code;
  PixelFormat format;
};
constexpr std::array kFourCcs = {
    FourCc{V4L2_PIX_FMT_MJPEG, PixelFormat::mjpeg}, FourCc{V4L2_PIX_FMT_JPEG, PixelFormat::mjpeg},
    FourCc{V4L2_PIX_FMT_YUYV, PixelFormat::yuyv},   FourCc{V4L2_PIX_FMT_NV12, PixelFormat::nv12},
    FourCc{V4L2_PIX_FMT_RGB24, PixelFormat::rgb24}, FourCc{V4L2_PIX_FMT_BGR24, PixelFormat::bgr24}};

std::optional<PixelFormat> format_from(uint32_t code) {
  for (const FourCc& known : kFourCcs) {
    if (known.code == code) return known.format;
  }
  return std::nullopt;
}

struct Offer {
  CameraMode mode;
  uint32_t code = 0;
};

// --- what the device offers ------------------------------------------------------------------------------------------

double fps_from(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0 : double(interval.denominator) / interval.numerator;
}

// The rate nearest to the wish at one size; 0 if the driver does not say.
double best_fps(int fd, uint32_t code, uint32_t width, uint32_t height, double wish) {
  double best = 0;
  const auto consider = [&](double fps) {
    if (fps > 0 && (best == 0 || std::abs(fps - wish) < std::abs(best - wish))) best = fps;
  };
  for (uint32_t index = 0; index < 64; ++index) {
    v4l2_frmivalenum entry{};
    entry.index = index;
    entry.pixel_format = code;
    entry.width = width;
    entry.height = height;
    if (call(fd, VIDIOC_ENUM_FRAMEINTERVALS, &entry) != 0) break;
    if (entry.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      consider(fps_from(entry.discrete));
      continue;
    }
    const double fastest = fps_from(entry.stepwise.min), slowest = fps_from(entry.stepwise.max);
    consider(std::min(fastest, std::max(slowest, wish)));
    break;
  }
  return best;
}

uint32_t nearest_step(uint32_t wish, uint32_t low, uint32_t high, uint32_t step) {
  const uint32_t inside = std::min(std::max(wish, low), high);
  return low + (inside - low) / std::max(step, 1U) * std::max(step, 1U);
}

void add_sizes(int fd, uint32_t code, const ModeWish& wish, std::vector<Offer>& offers) {
  const auto format = format_from(code);
  const auto add = [&](uint32_t width, uint32_t height) {
    const double fps = best_fps(fd, code, width, height, wish.fps);
    offers.push_back({{*format, static_cast<int>(width), static_cast<int>(height), fps, kSettle_s}, code});
  };
  for (uint32_t index = 0; index < 256; ++index) {
    v4l2_frmsizeenum entry{};
    entry.index = index;
    entry.pixel_format = code;
    if (call(fd, VIDIOC_ENUM_FRAMESIZES, &entry) != 0) {
      if (index == 0) add(static_cast<uint32_t>(wish.width), static_cast<uint32_t>(wish.height));
      return;
    }
    if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      add(entry.discrete.width, entry.discrete.height);
      continue;
    }
    const auto& range = entry.stepwise;
    add(nearest_step(static_cast<uint32_t>(wish.width), range.min_width, range.max_width, range.step_width),
        nearest_step(static_cast<uint32_t>(wish.height), range.min_height, range.max_height, range.step_height));
    return;
  }
}

std::vector<Offer> offers_of(int fd, uint32_t type, const ModeWish& wish) {
  std::vector<Offer> offers;
  for (uint32_t index = 0; index < 128; ++index) {
    v4l2_fmtdesc entry{};
    entry.index = index;
    entry.type = type;
    if (call(fd, VIDIOC_ENUM_FMT, &entry) != 0) break;
    if (format_from(entry.pixelformat)) add_sizes(fd, entry.pixelformat, wish, offers);
  }
  return offers;
}

// --- buffers ---------------------------------------------------------------------------------------------------------

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
    return ldp::call(fd, request, &buffer);
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

// --- controls --------------------------------------------------------------------------------------------------------

// Freezes what cameras adjust by themselves and remembers how it was.
class AutomaticControls {
 public:
  bool lock(int fd) {
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

  void unlock(int fd) {
    for (const auto& [id, value] : before_) write(fd, id, value);
    before_.clear();
  }

 private:
  static std::optional<int32_t> get(int fd, uint32_t id) {
    v4l2_control control{id, 0};
    if (call(fd, VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
    return control.value;
  }
  static bool write(int fd, uint32_t id, int32_t value) {
    v4l2_control control{id, value};
    return call(fd, VIDIOC_S_CTRL, &control) == 0;
  }
  bool set(int fd, uint32_t id, int32_t value) {
    const auto before = get(fd, id);
    if (!before || !write(fd, id, value)) return false;
    before_.try_emplace(id, *before);
    return true;
  }

  std::map<uint32_t, int32_t> before_;
};

// --- the camera ------------------------------------------------------------------------------------------------------

class V4l2Camera final : public CameraDevice {
 public:
  explicit V4l2Camera(const Url& url) : path_(url.path()), stream_(std::make_shared<Stream>()) {
    const ModeWish wish = wish_from(url);
    stream_->fd.reset(::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    if (fd() < 0) throw_errno("cannot open the camera '" + path_ + "'");
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
