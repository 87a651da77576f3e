// Where the frames of a session's sweeps go: a capture folder for each (capture_store.h), or, of a single sweep without
// a build, the output folder itself.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "device/capture/capture_store.h"
#include "device/capture/frame_writer.h"
#include "device/service/config/config.h"

namespace ldp {

class SweepFolders {
 public:
  // Both must live longer. `one_only`: the output folder itself takes the frames, and nothing is removed from it.
  SweepFolders(const Config& config, const CaptureStore& store, bool one_only)
      : config_(config), store_(store), one_only_(one_only) {}

  int sweeps_left() const;     // that fit on the disk beside the reserve; throws std::system_error
  std::string create() const;  // gives the capture's name; throws
  std::filesystem::path of(const std::string& capture) const;
  void discard(const std::string& capture) const;  // with its frames, if there is such a folder

  // A cancelled capture goes when nothing is written into it any more.
  void cancel(const std::string& capture, FrameWriter& writer);
  void discard_cancelled(const FrameWriter& writer);

 private:
  const Config& config_;
  const CaptureStore& store_;
  bool one_only_;
  std::vector<std::string> cancelled_;
};

}  // namespace ldp
