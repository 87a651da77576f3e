// Writes frames to disk on a thread of its own, because fsync on a memory card takes as long as it likes; what is done
// comes back through a file descriptor.
#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
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
  std::string error;  // empty: the file is whole and on disk for good
};

class FrameWriter {
 public:
  FrameWriter();
  ~FrameWriter();  // writes what is queued first
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  void put(WriteJob job);
  int fd() const { return event_.get(); }  // readable when `take` may give something
  std::optional<WriteOutcome> take();
  size_t pending() const;  // jobs whose outcome was not taken

 private:
  void run();

  UniqueFd event_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<WriteJob> jobs_;
  std::deque<WriteOutcome> outcomes_;
  size_t pending_ = 0;
  bool ending_ = false;
  std::thread thread_;  // last: runs only while everything else exists
};

}  // namespace ldp
