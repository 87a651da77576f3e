// A camera back-end of one's own: any program that writes JPEG after JPEG to its standard output. Frames are stored:
//   pipe_camera 'ffmpeg -i clip.mp4 -r 2 -f mjpeg -' capture/ && ldp build capture/ -o room.ldp
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include "core/base/files.h"
#include "drivers/interface/camera.h"
#include "drivers/interface/clocks.h"

class PipeCamera final : public ldp::CameraDevice {
 public:
  explicit PipeCamera(std::string command) : command_(std::move(command)) {}
  ~PipeCamera() override { stop(); }
  std::string name() const override { return command_; }
  ldp::CameraMode mode() const override { return {}; }  // JPEG, of whatever size
  void start() override {
    if ((pipe_ = ::popen(command_.c_str(), "r")) == nullptr) throw ldp::CameraLost(command_ + ": cannot be started");
    ::fcntl(fd(), F_SETFL, O_NONBLOCK);
  }
  void stop() noexcept override { pipe_ = pipe_ != nullptr ? (::pclose(pipe_), nullptr) : nullptr; }
  int fd() const override { return ::fileno(pipe_); }
  std::optional<ldp::CameraFrame> read() override {
    char some[65536];
    const ssize_t got = ::read(fd(), some, sizeof some);
    if (got > 0) bytes_.append(some, static_cast<size_t>(got));
    const size_t end = bytes_.find("\xff\xd9");  // of a JPEG without thumbnail, nowhere inside one
    if (end == std::string::npos) return got != 0 ? std::nullopt : throw ldp::CameraLost(command_ + ": has ended");
    const auto kept = std::make_shared<std::string>(bytes_.substr(0, end + 2));
    bytes_.erase(0, end + 2);
    ldp::CameraFrame frame;
    frame.sequence = count_++, frame.time_ns = ldp::monotonic_now_ns(), frame.lease = kept;
    frame.planes.push_back({reinterpret_cast<const uint8_t*>(kept->data()), kept->size(), 0});
    return frame;
  }
  bool lock_exposure(bool) override { return false; }

 private:
  std::string command_, bytes_;
  FILE* pipe_ = nullptr;
  int64_t count_ = 0;
};

int main(int argc, char** argv) try {
  PipeCamera camera(argc == 3 ? argv[1] : throw ldp::CameraLost("usage: pipe_camera COMMAND FOLDER"));
  std::filesystem::create_directories(argv[2]);
  for (camera.start();;) {
    pollfd readable{camera.fd(), POLLIN, 0};
    ::poll(&readable, 1, -1);
    while (const auto frame = camera.read())
      ldp::write_file(std::filesystem::path(argv[2]) / ("frame_" + std::to_string(1000 + frame->sequence) + ".jpg"),
                      {frame->planes[0].bytes, frame->planes[0].size});
  }
} catch (const ldp::CameraLost& end) {
  return std::fprintf(stderr, "%s\n", end.what()), 0;
}
