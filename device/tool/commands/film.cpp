#include "device/tool/commands/film.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <string>
#include <system_error>
#include <vector>

#include "core/base/files.h"
#include "core/base/job.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/process/interrupt.h"
#include "device/tool/session.h"

extern char** environ;

namespace ldp {
namespace {

std::vector<std::string> command_line(const std::filesystem::path& output, int width, int height) {
  std::vector<std::string> words = {"ffmpeg",
                                    "-v",
                                    "error",
                                    "-nostdin",
                                    "-y",
                                    "-f",
                                    "rawvideo",
                                    "-pix_fmt",
                                    "rgb24",
                                    "-s",
                                    std::to_string(width) + "x" + std::to_string(height),
                                    "-r",
                                    "30",
                                    "-i",
                                    "pipe:0"};
  // Players want 4:2:0, which needs even sides.
  if (extension_of(output) != ".gif")
    words.insert(words.end(), {"-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p"});
  words.insert(words.end(), {"-metadata", std::string("comment=") + kRendered});  // a .gif has no room for it
  words.push_back(output.string());
  return words;
}

}  // namespace

bool names_a_film(const std::filesystem::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".mp4" || extension == ".webm" || extension == ".gif";
}

Film::Film(const std::filesystem::path& file, int width, int height) : file_(file) {
  std::string name = ".";
  name += file.stem().string() + ".partial-" + std::to_string(::getpid()) + file.extension().string();
  partial_ = file.parent_path() / name;
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw std::system_error(errno, std::generic_category(), "opening a pipe to ffmpeg");
  pipe_ = ends[1];
  errors_ = ::memfd_create("ffmpeg", MFD_CLOEXEC);
  ::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that ends early is reported by its exit status
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  if (errors_ >= 0) ::posix_spawn_file_actions_adddup2(&actions, errors_, STDERR_FILENO);
  std::vector<std::string> words = command_line(partial_, width, height);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  temporary_ = std::make_unique<Temporary>(partial_);
  const int error = ::posix_spawnp(&process_, "ffmpeg", &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[0]);
  if (error == 0) return;
  ::close(pipe_);
  ::close(errors_);
  throw BadInput(file.string() + ": films need ffmpeg, which could not be started: install it, or give a folder to -o");
}

Film::~Film() {
  close_and_wait();
  ::close(errors_);
  std::error_code ignored;
  if (!partial_.empty()) std::filesystem::remove(partial_, ignored);
}

void Film::add(const RgbImage& picture) {
  static_assert(sizeof(Rgb) == 3);
  const auto* bytes = reinterpret_cast<const char*>(picture.samples.data());
  size_t left = 3 * picture.samples.size();
  while (left > 0) {
    const ssize_t written = ::write(pipe_, bytes, left);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      close_and_wait();
      fail();
    }
    bytes += written;
    left -= static_cast<size_t>(written);
  }
}

int Film::close_and_wait() {
  if (process_ < 0) return 0;
  ::close(pipe_);
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
  process_ = -1;
  return status;
}

// By the first line that ffmpeg said, which gives the cause, with the film's own name.
void Film::fail() const {
  std::string said(1000, '\0');
  said.resize(static_cast<size_t>(std::max<ssize_t>(::pread(errors_, said.data(), said.size(), 0), 0)));
  said.resize(std::min(said.find('\n'), said.size()));
  const std::string partial = partial_.string();
  if (const size_t at = said.find(partial); at != std::string::npos) said.replace(at, partial.size(), file_.string());
  throw Impossible(file_.string() + ": ffmpeg failed" + (said.empty() ? "" : ": " + said));
}

void Film::keep() {
  if (close_and_wait() != 0) fail();
  move_file(partial_, file_);
  partial_.clear();
}

}  // namespace ldp
