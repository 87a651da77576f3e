#include "device/service/sweep_folders.h"

#include <exception>
#include <utility>

#include "device/capture/log.h"

namespace ldp {

int SweepFolders::sweeps_left() const {
  return store_.sweeps_left(uint64_t{static_cast<unsigned>(config_.reserve_mib)} << 20);
}

std::string SweepFolders::create() const {
  return one_only_ ? std::filesystem::path(config_.output).filename().string() : store_.create_capture();
}

std::filesystem::path SweepFolders::of(const std::string& capture) const {
  return one_only_ ? std::filesystem::path(config_.output) : store_.folder_of(capture);
}

void SweepFolders::discard(const std::string& capture) const {
  if (capture.empty() || one_only_) return;
  try {
    store_.discard(capture);
  } catch (const std::exception& error) {
    log_warning(error.what());
  }
}

void SweepFolders::cancel(const std::string& capture, FrameWriter& writer) {
  writer.forget(of(capture));
  cancelled_.push_back(capture);
  discard_cancelled(writer);
}

// The writer must not write into a folder that is being removed.
void SweepFolders::discard_cancelled(const FrameWriter& writer) {
  if (writer.pending() > 0) return;
  for (const std::string& capture : std::exchange(cancelled_, {})) discard(capture);
}

}  // namespace ldp
