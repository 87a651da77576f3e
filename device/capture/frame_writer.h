// Writes frames to disk on a thread of its own, because fsync on a memory card takes as long as it likes; what is done
// comes back through a file descriptor.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "device/capture/capture_store.h"
#include "drivers/interface/unique_fd.h"

namespace ldp {

struct WriteJob {
  std::filesystem::path folder;
  std::string file;  // of the frame; empty: only capture.json
  std::vector<uint8_t> bytes;
  std::string capture_json;  // as of this frame
};

struct WriteOutcome {
  std::filesystem::path folder;  // as in the job, and
  std::string file;
  std::string error;     // empty: the file is whole and on disk for good
  std::error_code code;  // of the system call that failed
};

class FrameWriter {
 public:
  FrameWriter();
  ~FrameWriter();  // writes what is queued first
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  void put(WriteJob job);
  void forget(const std::filesystem::path& folder);  // its jobs that are not begun
  // Leaves the thread to itself and what is queued unwritten: where a disk does not answer, waiting would be for ever.
  void leave();
  int fd() const { return shared_->event.get(); }  // readable when `take` may give something
  std::optional<WriteOutcome> take();
  size_t pending() const;  // jobs whose outcome was not taken

 private:
  struct Entry {
    WriteJob job;
    std::string error;
    std::error_code code;
  };
  // With the thread, which may outlive the writer. Entries wander from list to list, so that the thread needs no memory
  // to tell how one ended.
  struct Shared {
    UniqueFd event;
    std::mutex mutex;
    std::condition_variable wake;
    std::list<Entry> jobs, done;
    size_t pending = 0;
    bool ending = false;
  };
  static void write(Entry& entry) noexcept;
  static void run(Shared& shared);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace ldp
