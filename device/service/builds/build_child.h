// A build in a process of its own: low priority, limited memory, progress through a pipe. Whatever becomes of it, the
// service goes on; when the service dies, so does the build.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/interface/unique_fd.h"

namespace ldp {

struct BuildCommand {
  std::filesystem::path program;       // ldp
  std::vector<std::string> arguments;  // without --progress-fd, which is added
  uint64_t memory_limit_bytes = 0;     // 0 = none
  int niceness = 10;
  bool is_told = false;  // lines on its standard input
};

struct BuildProgress {
  double fraction = 0;
  std::string stage;
};

struct BuildEnd {
  bool ok = false;
  std::string reason;  // the last line of its standard error, or what killed it
  // It came to no verdict on the frames: killed, a full disk or no memory (status 75), a wrong option. Another time may
  // go better.
  bool retry = false;
};

class BuildChild {
 public:
  explicit BuildChild(const BuildCommand& command);  // throws std::system_error
  ~BuildChild();                                     // kills it and waits for it
  BuildChild(const BuildChild&) = delete;
  BuildChild& operator=(const BuildChild&) = delete;

  int end_fd() const { return process_.get(); }        // readable when it has ended
  int progress_fd() const { return progress_.get(); }  // readable when there is progress; -1 once it is closed
  int error_fd() const { return errors_.get(); }       // readable when it complains; -1 once it is closed

  std::optional<BuildProgress> read_progress();  // the newest, if there is a new one
  // What the person should hear before it ends, once: of what read_progress has read.
  std::optional<std::string> take_remark() { return std::exchange(remark_, std::nullopt); }
  void read_errors();
  void tell(const std::string& line);  // throws std::system_error when it does not listen
  std::optional<BuildEnd> end();       // none while it runs; what is read after it is all that it said
  void kill();

 private:
  pid_t pid_ = -1;
  UniqueFd process_, progress_, errors_, lines_;
  std::string progress_text_, error_text_;
  std::optional<std::string> remark_;
  std::optional<BuildEnd> end_;
};

// Lines "FRACTION STAGE" as ldp build --progress-fd writes them; none for anything else.
std::optional<BuildProgress> parse_progress(const std::string& line);

}  // namespace ldp
