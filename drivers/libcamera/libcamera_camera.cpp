// Cameras of boards (image signal processors and sensors) and webcams through libcamera, 0.0.3 and later.
//
// libcamera completes requests on its own thread. That thread only puts them into a queue and raises an event
// descriptor; everything else happens on the thread that reads the camera.
#include <libcamera/libcamera.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "drivers/backends.h"
#include "drivers/interface/clocks.h"
#include "drivers/libcamera/libcamera_session.h"
#include "drivers/v4l2_modes.h"

#define LDP_LIBCAMERA_AT_LEAST(major, minor) \
  (LIBCAMERA_VERSION_MAJOR > (major) || (LIBCAMERA_VERSION_MAJOR == (major) && LIBCAMERA_VERSION_MINOR >= (minor)))

namespace ldp {
namespace {

constexpr unsigned kBuffers = 6;   // as many as the pipeline allows of them
constexpr double kSettle_s = 0.5;  // automatic exposure after the start of the stream

// libcamera names formats as DRM does, from the most significant byte of a little-endian word: its BGR888 is R, G, B in
// memory.
struct KnownFormat {
  libcamera::PixelFormat theirs;
  PixelFormat ours;
};
const std::array<KnownFormat, 5>& known_formats() {
  static const std::array<KnownFormat, 5> known = {{{libcamera::formats::MJPEG, PixelFormat::mjpeg},
                                                    {libcamera::formats::NV12, PixelFormat::nv12},
                                                    {libcamera::formats::YUYV, PixelFormat::yuyv},
                                                    {libcamera::formats::BGR888, PixelFormat::rgb24},
                                                    {libcamera::formats::RGB888, PixelFormat::bgr24}}};
  return known;
}

std::optional<PixelFormat> format_from(const libcamera::PixelFormat& theirs) {
  for (const KnownFormat& known : known_formats()) {
    if (known.theirs == theirs) return known.ours;
  }
  return std::nullopt;
}

std::shared_ptr<libcamera::Camera> find_camera(const libcamera::CameraManager& manager, const Url& url) {
  const auto cameras = manager.cameras();
  if (cameras.empty()) throw std::runtime_error("'" + url.text() + "': libcamera sees no camera; 'cam -l' lists them");
  const std::string& wanted = url.path();
  for (const auto& camera : cameras) {
    if (camera->id() == wanted) return camera;
  }
  const bool is_index =
      !wanted.empty() && wanted.size() < 4 && wanted.find_first_not_of("0123456789") == std::string::npos;
  const size_t index = is_index ? std::stoul(wanted) : cameras.size();
  if (index < cameras.size()) return cameras[index];
  std::string known;
  for (size_t i = 0; i < cameras.size(); ++i)
    known.append(" ").append(std::to_string(i)).append(" = ").append(cameras[i]->id());
  throw std::runtime_error("'" + url.text() + "': libcamera has no such camera; it has" + known);
}

class LibcameraCamera final : public CameraDevice {
 public:
  explicit LibcameraCamera(const Url& url) : session_(std::make_shared<LibcameraSession>()) {
    const ModeWish wish = wish_from(url);
    session_->camera = find_camera(session_->manager, url);
    if (session_->camera->acquire() != 0) {
      session_->camera.reset();
      throw std::runtime_error("'" + url.text() + "': the camera is in use by another program");
    }
    configure(url, wish);
    allocate(url);
    session_->camera->requestCompleted.connect(this, &LibcameraCamera::on_completed);
    session_->camera->disconnected.connect(this, &LibcameraCamera::on_disconnected);
  }
  LibcameraCamera(const LibcameraCamera&) = delete;
  LibcameraCamera& operator=(const LibcameraCamera&) = delete;
  ~LibcameraCamera() override {
    stop();
    session_->camera->requestCompleted.disconnect(this);
    session_->camera->disconnected.disconnect(this);
  }

  std::string name() const override { return session_->camera->id(); }
  CameraMode mode() const override { return mode_; }
  int fd() const override { return session_->completed.fd(); }

  void start() override {
    stop();
    make_requests();
    libcamera::ControlList controls(libcamera::controls::controls);
    if (has(libcamera::controls::FrameDurationLimits.id())) {
      const auto duration_us = static_cast<int64_t>(1e6 / mode_.fps);
      controls.set(libcamera::controls::FrameDurationLimits,
                   libcamera::Span<const int64_t, 2>({duration_us, duration_us}));
    }
    const int error = session_->camera->start(&controls);
    if (error != 0) throw CameraLost("camera '" + name() + "' cannot start: " + std::strerror(-error));
    session_->running = true;
    for (const auto& request : session_->requests) session_->camera->queueRequest(request.get());
  }

  void stop() override { session_->stop(); }

  std::optional<CameraFrame> read() override {
    while (libcamera::Request* const request = session_->completed.take()) {
      if (request->status() == libcamera::Request::RequestCancelled) continue;
      if (auto frame = frame_from(*request)) return frame;
      session_->give_back(request, session_->generation);
    }
    if (session_->completed.disconnected()) throw CameraLost("camera '" + name() + "': it was disconnected");
    return std::nullopt;
  }

  bool lock_exposure(bool locked) override {
    bool any = false;
    auto& pending = session_->pending_controls;
    if (has(libcamera::controls::AeEnable.id())) {
      pending.set(libcamera::controls::AeEnable, !locked);
      any = true;
    }
    if (has(libcamera::controls::AwbEnable.id())) pending.set(libcamera::controls::AwbEnable, !locked);
    return any;
  }

 private:
  void on_completed(libcamera::Request* request) { session_->completed.put(request); }
  void on_disconnected() { session_->completed.disconnect(); }

  bool has(unsigned control) const {
    const auto& controls = session_->camera->controls();
    return controls.find(control) != controls.end();
  }

  void configure(const Url& url, const ModeWish& wish) {
    session_->configuration = session_->camera->generateConfiguration({libcamera::StreamRole::VideoRecording});
    if (!session_->configuration || session_->configuration->size() == 0) {
      session_->configuration = session_->camera->generateConfiguration({libcamera::StreamRole::Viewfinder});
    }
    if (!session_->configuration || session_->configuration->size() == 0) {
      throw std::runtime_error("'" + url.text() + "': the camera cannot stream video");
    }
    libcamera::StreamConfiguration& stream = session_->configuration->at(0);
    stream.pixelFormat = wanted_format(url, wish, stream);
    stream.size.width = static_cast<unsigned>(wish.width);
    stream.size.height = static_cast<unsigned>(wish.height);
    stream.bufferCount = kBuffers;
    if (session_->configuration->validate() == libcamera::CameraConfiguration::Invalid) {
      throw std::runtime_error("'" + url.text() + "': the camera refuses this size and format");
    }
    const auto format = format_from(stream.pixelFormat);
    if (!format) {
      throw std::runtime_error("'" + url.text() + "': the camera gives " + stream.pixelFormat.toString() +
                               ", which is not known here");
    }
    const int error = session_->camera->configure(session_->configuration.get());
    if (error != 0)
      throw std::runtime_error("'" + url.text() + "': cannot configure the camera: " + std::strerror(-error));
    const bool settles = has(libcamera::controls::AeEnable.id());
    mode_ = {*format, static_cast<int>(stream.size.width), static_cast<int>(stream.size.height), wish.fps,
             settles ? kSettle_s : 0};
    stride_ = static_cast<int>(stream.stride);
  }

  // The first of ours that the stream offers, or the one asked for.
  static libcamera::PixelFormat wanted_format(const Url& url, const ModeWish& wish,
                                              const libcamera::StreamConfiguration& stream) {
    const auto offered = stream.formats().pixelformats();
    for (const KnownFormat& known : known_formats()) {
      if (wish.format && *wish.format != known.ours) continue;
      if (std::find(offered.begin(), offered.end(), known.theirs) != offered.end()) return known.theirs;
    }
    if (wish.format) {
      throw std::runtime_error("'" + url.text() + "': the camera does not offer " + name_of(*wish.format));
    }
    return stream.pixelFormat;
  }

  void allocate(const Url& url) {
    session_->allocator = std::make_unique<libcamera::FrameBufferAllocator>(session_->camera);
    libcamera::Stream* const stream = session_->configuration->at(0).stream();
    if (session_->allocator->allocate(stream) < 0)
      throw std::runtime_error("'" + url.text() + "': no memory for frames");
    for (const auto& buffer : session_->allocator->buffers(stream)) {
      session_->mapped[buffer.get()] = std::make_unique<MappedBuffer>(*buffer);
    }
  }

  void make_requests() {
    libcamera::Stream* const stream = session_->configuration->at(0).stream();
    session_->requests.clear();
    ++session_->generation;
    for (const auto& buffer : session_->allocator->buffers(stream)) {
      std::unique_ptr<libcamera::Request> request = session_->camera->createRequest();
      if (!request || request->addBuffer(stream, buffer.get()) != 0) {
        throw CameraLost("camera '" + name() + "': cannot make a request");
      }
      session_->requests.push_back(std::move(request));
    }
  }

  std::optional<CameraFrame> frame_from(libcamera::Request& request) const {
    const libcamera::FrameBuffer* const buffer = request.buffers().begin()->second;
    const libcamera::FrameMetadata& metadata = buffer->metadata();
    if (metadata.status != libcamera::FrameMetadata::FrameSuccess) return std::nullopt;
    CameraFrame frame;
    frame.format = mode_.format;
    frame.width = mode_.width;
    frame.height = mode_.height;
    frame.planes = planes_of(*session_->mapped.at(buffer), metadata);
    if (frame.planes.empty()) return std::nullopt;
    frame.sequence = metadata.sequence;
    frame.time_ns = metadata.timestamp != 0 ? static_cast<int64_t>(metadata.timestamp) : monotonic_now_ns();
    read_exposure(request.metadata(), frame);
    frame.lease = std::shared_ptr<const void>(
        &request, [session = session_, returned = &request, generation = session_->generation](const void*) {
          session->give_back(returned, generation);
        });
    return frame;
  }

  // Metadata's getters changed their return type (value with contains(), then optional).
  static void read_exposure(const libcamera::ControlList& metadata, CameraFrame& frame) {
#if LDP_LIBCAMERA_AT_LEAST(0, 1)
    if (const auto exposure_us = metadata.get(libcamera::controls::ExposureTime))
      frame.exposure_s = *exposure_us * 1e-6;
    if (const auto gain = metadata.get(libcamera::controls::AnalogueGain)) frame.gain = static_cast<double>(*gain);
#else
    const unsigned exposure = libcamera::controls::ExposureTime.id(), gain = libcamera::controls::AnalogueGain.id();
    if (metadata.contains(exposure)) frame.exposure_s = metadata.get(exposure).get<int32_t>() * 1e-6;
    if (metadata.contains(gain)) frame.gain = static_cast<double>(metadata.get(gain).get<float>());
#endif
  }

  // Empty if the frame is cut short.
  std::vector<FramePlane> planes_of(const MappedBuffer& mapped, const libcamera::FrameMetadata& metadata) const {
    std::vector<FramePlane> planes = mapped.planes();
    for (size_t i = 0; i < planes.size() && i < metadata.planes().size(); ++i) {
      planes[i].size = std::min(planes[i].size, size_t{metadata.planes()[i].bytesused});
      planes[i].stride = stride_;
    }
    const size_t rows = static_cast<size_t>(mode_.height) * static_cast<size_t>(stride_);
    if (mode_.format == PixelFormat::mjpeg) {
      planes.resize(1);
      planes[0].stride = 0;
      const bool whole = planes[0].size > 4 && planes[0].bytes[0] == 0xFF && planes[0].bytes[1] == 0xD8;
      return whole ? planes : std::vector<FramePlane>{};
    }
    if (mode_.format == PixelFormat::nv12 && planes.size() == 1 && planes[0].size >= rows * 3 / 2) {
      planes.push_back({planes[0].bytes + rows, planes[0].size - rows, stride_});
    }
    if (planes[0].size < rows) return {};
    if (mode_.format == PixelFormat::nv12 && (planes.size() < 2 || planes[1].size < rows / 2)) return {};
    return planes;
  }

  std::shared_ptr<LibcameraSession> session_;
  CameraMode mode_;
  int stride_ = 0;
};

}  // namespace

void check_libcamera_camera(const Url& url) { wish_from(url); }

std::unique_ptr<CameraDevice> open_libcamera_camera(const Url& url) { return std::make_unique<LibcameraCamera>(url); }

}  // namespace ldp
