// Where captures and panoramas lie, and that nothing half written is ever taken for whole.
//
//   OUTPUT/sweep_000012/frame_000.jpg ...   the frames, each written at once and for good
//   OUTPUT/sweep_000012/capture.json        what is known about the sweep; rewritten with every frame
//   OUTPUT/sweep_000012/build.json          interrupted, failed and cancelled builds
//   OUTPUT/sweep_000012.ldp                 the panorama
//   OUTPUT/.building/                       builds in progress, and captures that go; emptied at start
//   OUTPUT/.lock                            locked by the one service that works here
//   OUTPUT/.last_sweep                      the last number given: a number is never given twice, whatever was deleted
//
// Every file is replaced as core/base/files.h says. Nothing is ever deleted but temporary files and what `discard` is
// asked to remove.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/interface/unique_fd.h"

namespace ldp {

struct FrameRecord {
  std::string file;
  int64_t time_ns = 0;  // monotonic
  int64_t sequence = 0;
  std::optional<double> exposure_s, gain;
};

// What capture.json says.
struct CaptureRecord {
  std::string device, camera;
  int width = 0, height = 0;
  std::string pixel_format;
  double arm_length_m = 0.65;
  std::optional<double> fov_rad;
  bool exposure_locked = false;
  int64_t begin_utc_ns = 0, begin_ns = 0, end_ns = 0;  // button times
  bool clock_synchronized = true;                      // else the first of them may be wrong by any amount
  bool complete = false;                               // the sweep was ended in order
  std::string end_reason;
  std::vector<FrameRecord> frames;
};

std::string capture_json(const CaptureRecord& record);

struct BuildRecord {
  int interruptions = 0;  // builds that were begun and came to no verdict
  bool cancelled = false, failed = false;
  std::string reason;
};

struct CaptureState {
  std::string name;
  int frames = 0;
  bool built = false;
  BuildRecord build;
};

class CaptureStore {
 public:
  explicit CaptureStore(std::filesystem::path output) : output_(std::move(output)) {}

  // Makes the folder where it is missing, warns where folders cannot be flushed; throws std::system_error if it cannot
  // be written. Gives the folders that it made, innermost first.
  std::vector<std::filesystem::path> prepare() const;

  // Held as long as the descriptor is open; the kernel lets go of it with the process, however that ends. Throws
  // std::runtime_error if another process holds it.
  [[nodiscard]] UniqueFd lock() const;

  // Of a store that nothing has come into: the folders that were made for it go again.
  void give_up(const std::vector<std::filesystem::path>& made) const;

  // Removes what an interrupted run left behind: temporary files, unfinished builds. Gives the captures in order.
  std::vector<CaptureState> recover() const;

  std::string create_capture() const;  // a new name; its folder is on disk
  void discard(const std::string& name) const;

  std::filesystem::path folder_of(const std::string& name) const { return output_ / name; }
  std::filesystem::path panorama_of(const std::string& name) const { return output_ / (name + ".ldp"); }
  std::filesystem::path building_of(const std::string& name) const { return output_ / ".building" / (name + ".ldp"); }

  std::filesystem::path report_of(const std::string& name) const { return output_ / ".building" / (name + ".json"); }

  void clear_building() const;
  void publish_panorama(const std::string& name) const;  // from .building to its place, for good
  void write_build_record(const std::string& name, const BuildRecord& record) const;
  BuildRecord read_build_record(const std::string& name) const;
  void forget_build_record(const std::string& name) const;

  // Free bytes beyond the reserve, divided by what the last sweeps took that have their panorama.
  int sweeps_left(uint64_t reserve_bytes) const;

 private:
  uint64_t usual_sweep_bytes() const;

  std::filesystem::path lock_file() const { return output_ / ".lock"; }

  std::filesystem::path output_;
};

}  // namespace ldp
