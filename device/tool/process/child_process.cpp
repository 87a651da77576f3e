#include "device/tool/process/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "device/tool/process/interrupt.h"

extern char** environ;

namespace ldp {
namespace {

constexpr int kStopCheck_ms = 50;
constexpr size_t kSaid_bytes = 1000;

}  // namespace

ChildProcess::ChildProcess(std::vector<std::string> words, Pipe pipe, uint64_t memory_bytes) {
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw std::system_error(errno, std::generic_category(), "opening a pipe to " + words[0]);
  const bool writes = pipe == Pipe::to_child;
  pipe_ = ends[writes ? 1 : 0];
  errors_ = ::memfd_create(words[0].c_str(), MFD_CLOEXEC);
  ::signal(SIGPIPE, SIG_IGN);  // one that ends early is reported by its exit status
  start(words, ends[writes ? 0 : 1], writes ? STDIN_FILENO : STDOUT_FILENO);
  end_ = std::make_unique<WhenCutOff>([process = process_] { ::kill(process, SIGKILL); });
  if (memory_bytes == 0) return;
  const auto most = static_cast<rlim_t>(std::min<uint64_t>(memory_bytes, std::numeric_limits<rlim_t>::max()));
  const rlimit limit{most, most};
  ::prlimit(process_, RLIMIT_AS, &limit, nullptr);
}

void ChildProcess::start(std::vector<std::string>& words, int its_end, int as) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, its_end, as);
  for (const int other : {STDIN_FILENO, STDOUT_FILENO})
    if (other != as) ::posix_spawn_file_actions_addopen(&actions, other, "/dev/null", O_RDWR, 0);
  if (errors_ >= 0) ::posix_spawn_file_actions_adddup2(&actions, errors_, STDERR_FILENO);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int error = ::posix_spawnp(&process_, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(its_end);
  if (error == 0) return;
  process_ = -1;
  close_pipe();
  if (errors_ >= 0) ::close(errors_);
  throw std::system_error(error, std::generic_category(), "starting " + words[0]);
}

ChildProcess::~ChildProcess() {
  end();
  if (errors_ >= 0) ::close(errors_);
}

void ChildProcess::close_pipe() {
  if (pipe_ >= 0) ::close(pipe_);
  pipe_ = -1;
}

bool ChildProcess::write(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(pipe_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

size_t ChildProcess::read(std::span<uint8_t> bytes, const Job& job) {
  size_t have = 0;
  while (have < bytes.size()) {
    job.check();
    pollfd entry{pipe_, POLLIN, 0};
    if (::poll(&entry, 1, kStopCheck_ms) <= 0) continue;
    const ssize_t got = ::read(pipe_, bytes.data() + have, bytes.size() - have);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got <= 0) break;
    have += static_cast<size_t>(got);
  }
  return have;
}

void ChildProcess::end() {
  if (process_ > 0) ::kill(process_, SIGKILL);
  wait();
}

int ChildProcess::wait() {
  close_pipe();
  if (process_ < 0) return status_;
  siginfo_t ended{};  // its number is not given to another one as long as it may be ended by it
  while (::waitid(P_PID, static_cast<id_t>(process_), &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR) continue;
  end_.reset();
  while (::waitpid(process_, &status_, 0) < 0 && errno == EINTR) continue;
  process_ = -1;
  return status_;
}

std::string ChildProcess::first_line_said() const {
  std::string said(kSaid_bytes, '\0');
  said.resize(static_cast<size_t>(std::max<ssize_t>(::pread(errors_, said.data(), said.size(), 0), 0)));
  said.resize(std::min(said.find('\n'), said.size()));
  return said;
}

}  // namespace ldp
