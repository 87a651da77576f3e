// Another program, found on the path, whose standard input or output is a pipe of ours. What it says on standard error
// is kept in memory.
//
// It never outlives this object, nor a program that is cut off (interrupt.h). One that works on foreign bytes can be
// held to an amount of memory.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/job.h"

namespace ldp {

class WhenCutOff;

class ChildProcess {
 public:
  enum class Pipe : uint8_t { to_child, from_child };

  // Throws std::system_error where it cannot be started; its code is ENOENT where there is no such program.
  // memory_bytes: of address space that it may take; 0 = as much as it likes.
  ChildProcess(std::vector<std::string> words, Pipe pipe, uint64_t memory_bytes = 0);
  ~ChildProcess();  // as `end`
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool write(std::span<const uint8_t> bytes);  // false: it reads no more
  // As many bytes as there are up to that many, fewer only at the end of its output. Throws Cancelled.
  size_t read(std::span<uint8_t> bytes, const Job& job);

  int wait();  // closes the pipe first; its status as of waitpid, the same when asked again
  void end();  // now, whatever it does
  std::string first_line_said() const;

 private:
  void start(std::vector<std::string>& words, int its_end, int as);
  void close_pipe();

  pid_t process_ = -1;
  int status_ = 0;
  int pipe_ = -1, errors_ = -1;
  std::unique_ptr<WhenCutOff> end_;
};

}  // namespace ldp
