#include "device/service/builds/build_child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>

#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "drivers/interface/errors.h"

namespace ldp {
namespace {

constexpr int kProgressFd = 3;
constexpr int kDeathPatience_ms = 2000;
constexpr size_t kPipeBytes = 65536;
constexpr std::string_view kRemark = "so far: ";       // as a stage is called that is none (progress_bar.h)
constexpr int kCannotBeDone = 1, kInternalError = 70;  // exit statuses of ldp build that another time would be the same
constexpr size_t kMaxErrorBytes = 4096;                // the end of what it says is kept

struct Pipe {
  UniqueFd read, write;
  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw_errno("cannot make a pipe");
    read.reset(ends[0]);
    write.reset(ends[1]);
    ::fcntl(read.get(), F_SETFL, O_NONBLOCK);
  }
};

// Lines to a child. A pipe to one that has died would end us by SIGPIPE; a socket can be asked not to.
struct LineSocket {
  UniqueFd parent, child;
  LineSocket() {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) throw_errno("cannot make a pair of sockets");
    parent.reset(ends[0]);
    child.reset(ends[1]);
  }
};

// What the child is to have as descriptors.
struct ChildEnds {
  int lines, progress, errors;
};

// Between fork and exec: only calls that are allowed there.
[[noreturn]] void become(const BuildCommand& command, char* const* arguments, const ChildEnds& ends, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // it died before the line above
  ::setpriority(PRIO_PROCESS, 0, command.niceness);
  if (command.memory_limit_bytes > 0) {
    const rlimit limit{command.memory_limit_bytes, command.memory_limit_bytes};
    ::setrlimit(RLIMIT_DATA, &limit);
  }
  const int oom = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);  // the build goes first, the service last
  if (oom >= 0) {
    [[maybe_unused]] const ssize_t written = ::write(oom, "800", 3);
  }
  ::signal(SIGPIPE, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  ::dup2(ends.lines >= 0 ? ends.lines : nothing, STDIN_FILENO);
  ::dup2(nothing, STDOUT_FILENO);
  ::dup2(ends.errors, STDERR_FILENO);
  if (ends.progress == kProgressFd) {
    ::fcntl(ends.progress, F_SETFD, 0);  // dup2 onto itself would leave it to be closed
  } else {
    ::dup2(ends.progress, kProgressFd);
  }
  ::close_range(kProgressFd + 1, ~0U, 0);  // a camera that some library left open would stay in use
  ::execv(arguments[0], arguments);
  static constexpr char kMessage[] = "cannot run the build program\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
  ::_exit(127);
}

// Appends what is there, no more than a pipe holds: one that says more, and faster than it is read, waits for the next
// turn of the loop as all others do. Closes the descriptor at its end.
void drain(UniqueFd& fd, std::string& text) {
  char buffer[4096];
  for (size_t read = 0; fd.is_open() && read < kPipeBytes;) {
    const ssize_t got = ::read(fd.get(), buffer, sizeof buffer);
    if (got > 0) {
      text.append(buffer, static_cast<size_t>(got));
      read += static_cast<size_t>(got);
      continue;
    }
    if (got < 0 && errno == EINTR) continue;
    if (got == 0 || errno != EAGAIN) fd.reset();
    return;
  }
}

std::string last_line(const std::string& text) {
  const size_t end = text.find_last_not_of(" \r\n\t");
  if (end == std::string::npos) return {};
  const size_t begin = text.find_last_of("\r\n", end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

std::string reason_of(int status, const std::string& errors) {
  std::string said = last_line(errors);
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    const std::string killed = std::string("the build was killed (") + ::strsignal(signal) + ")";
    return said.empty() ? killed : killed + ": " + said;
  }
  if (!said.empty()) return said;
  return "the build ended with status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

BuildChild::BuildChild(const BuildCommand& command) {
  Pipe progress, errors;
  std::vector<std::string> words{command.program.string()};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  words.insert(words.end(), {"--progress-fd", std::to_string(kProgressFd)});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::optional<LineSocket> lines;
  if (command.is_told) lines.emplace();
  const ChildEnds ends{lines ? lines->child.get() : -1, progress.write.get(), errors.write.get()};
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) throw_errno("cannot start the build");
  if (pid_ == 0) become(command, arguments.data(), ends, parent);
  process_.reset(static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0U)));
  // Where nobody is to be told of its end, one that is over already is nowhere: end() will find none.
  if (!process_.is_open() && errno == ESRCH) process_.reset(::eventfd(1, EFD_CLOEXEC));
  if (!process_.is_open()) {
    const int error = errno;
    kill();
    throw_errno("cannot watch the build", error);
  }
  progress_ = std::move(progress.read);
  errors_ = std::move(errors.read);
  if (lines) lines_ = std::move(lines->parent);
}

BuildChild::~BuildChild() {
  if (!end_) kill();
}

std::optional<BuildProgress> BuildChild::read_progress() {
  drain(progress_, progress_text_);
  std::optional<BuildProgress> newest;
  for (size_t line_end = 0; (line_end = progress_text_.find('\n')) != std::string::npos;) {
    const auto progress = parse_progress(progress_text_.substr(0, line_end));
    if (progress && progress->stage.starts_with(kRemark))
      remark_ = progress->stage.substr(kRemark.size());
    else if (progress)
      newest = progress;
    progress_text_.erase(0, line_end + 1);
  }
  if (progress_text_.size() > kMaxErrorBytes) progress_text_.clear();
  return newest;
}

void BuildChild::read_errors() {
  drain(errors_, error_text_);
  if (error_text_.size() > kMaxErrorBytes) error_text_.erase(0, error_text_.size() - kMaxErrorBytes);
}

// All lines of a sweep fit into the socket; one that does not finds a child that hangs.
void BuildChild::tell(const std::string& line) {
  const std::string text = line + "\n";
  const ssize_t sent = ::send(lines_.get(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent != static_cast<ssize_t>(text.size())) throw_errno("the build does not listen");
}

std::optional<BuildEnd> BuildChild::end() {
  if (end_) return end_;
  int status = 0;
  const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
  if (ended < 0 && errno == ECHILD) return end_ = BuildEnd{false, "the system did not tell how the build ended", true};
  if (ended != pid_) return std::nullopt;
  read_errors();
  const int exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  const bool ok = exit_status == 0;
  const bool verdict = ok || exit_status == kCannotBeDone || exit_status == kInternalError;
  end_ = BuildEnd{ok, ok ? std::string() : reason_of(status, error_text_), !verdict};
  return end_;
}

void BuildChild::kill() {
  if (end_ || pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  // One that waits for a disk that does not answer cannot die: it is left to whoever inherits it.
  pollfd entry{process_.get(), POLLIN, 0};
  if (process_.is_open()) ::poll(&entry, 1, kDeathPatience_ms);
  int status = 0;
  while (::waitpid(pid_, &status, process_.is_open() ? WNOHANG : 0) < 0 && errno == EINTR) {
  }
  end_ = BuildEnd{false, "the build was stopped", true};
}

std::optional<BuildProgress> parse_progress(const std::string& line) {
  char* end = nullptr;
  const double fraction = std::strtod(line.c_str(), &end);
  if (end == line.c_str() || !std::isfinite(fraction) || fraction < 0 || fraction > 1) return std::nullopt;
  while (*end == ' ') ++end;
  return BuildProgress{fraction, end};
}

}  // namespace ldp
