#include "device/tool/commands/follow_capture.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <vector>

namespace ldp {
namespace {

constexpr int kCheckEvery_ms = 50;

class Lines {
 public:
  explicit Lines(int fd) : fd_(fd) {}

  // All that wait, at least one. Throws Impossible when there will be none.
  std::vector<std::string> next(const Job& job) {
    while (text_.find('\n') == std::string::npos) read_more(job);
    std::vector<std::string> lines;
    for (size_t end = 0; (end = text_.find('\n')) != std::string::npos; text_.erase(0, end + 1)) {
      lines.push_back(text_.substr(0, end));
    }
    return lines;
  }

 private:
  void read_more(const Job& job) {
    job.check();
    pollfd entry{fd_, POLLIN, 0};
    if (::poll(&entry, 1, kCheckEvery_ms) <= 0) return;
    char buffer[4096];
    const ssize_t got = ::read(fd_, buffer, sizeof buffer);
    if (got > 0) text_.append(buffer, static_cast<size_t>(got));
    if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN))
      throw Impossible("--follow: standard input ended before the line 'end': the sweep broke off, nothing was built");
  }

  int fd_;
  std::string text_;
};

size_t index_of(const std::vector<PhotoFile>& photos, const std::string& name, const std::string& folder) {
  for (size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].path.filename() == name) return i;
  }
  throw std::runtime_error(folder + ": there is no photo '" + name + "' in it: name photos once they are stored");
}

}  // namespace

PoseEstimator follow_capture(const BuildSetup& setup, int lines_fd, const Job& job) {
  Lines lines(lines_fd);
  PoseEstimator poses{PosesOptions{}};
  for (;;) {
    std::vector<std::string> names = lines.next(job);
    const bool complete = names.back() == "end";
    if (complete) names.pop_back();
    if (names.empty()) return poses;
    std::vector<PhotoFile> photos = photos_of_capture(setup.capture());
    size_t count = static_cast<size_t>(poses.size());
    for (const std::string& name : names) count = std::max(count, index_of(photos, name, setup.capture()) + 1);
    if (complete) return poses;
    photos.resize(std::min(count, photos.size()));  // what comes after may still be being written
    const FolderFrames frames = open_photos(setup, std::move(photos));
    if (poses.size() == 0) poses = PoseEstimator(poses_options(setup, read_capture_notes(setup.capture()), frames));
    poses.add_frames(frames, frames.size(), job);
  }
}

}  // namespace ldp
