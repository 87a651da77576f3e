// What `build`, `evaluate` and `poses` share: the options of a build, and the capture they apply to.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/captures/folder_frames.h"
#include "core/pipeline/build.h"
#include "device/tool/intake/intake.h"

namespace ldp {

constexpr int kFewestPhotos = 3;  // of one sweep, that make a panorama

struct BuildSetup {
  std::vector<std::string> captures;  // what the photos come in (intake/intake.h)
  std::string cameras;                // transforms.json or empty
  std::string scratch;                // folder for what is unpacked meanwhile; empty = the system's
  double megapixels = 2.1;            // of a frame at most
  bool trimmed = true;                // whether photos that differ by a few pixels are of one camera
  int turn_deg = 0;                   // clockwise, that makes photos upright
  double fov_deg = 0;                 // 0 = from the photos
  double arm_length = 0;              // 0 = from capture.json, else the default
  std::optional<int> colour_quality;  // none = as exact as the photographs bear it out
  BuildOptions build;

  std::string capture() const;  // in words
};

void add_capture_options(CLI::App& command, BuildSetup& setup);  // the photos, and how poses are found
void add_build_options(CLI::App& command, BuildSetup& setup);    // everything else

struct PreparedBuild {
  Intake intake;  // what the frames lie in
  FolderFrames frames;
  CaptureNotes notes;
  BuildOptions options;  // complete: notes and given cameras applied
};

FolderFrames open_photos(const BuildSetup& setup, std::vector<PhotoFile> photos);
PosesOptions poses_options(const BuildSetup& setup, const CaptureNotes& notes, const FolderFrames& frames);

// Throws BadInput where a capture has no name, or parts of one with spaces that lacks its quotes.
void check_names(const BuildSetup& setup);

// Reads what the options name, and unpacks it. Throws BadInput or std::runtime_error.
PreparedBuild prepare(const BuildSetup& setup, const Job& job);

// Throws BadInput where pictures that go to `folder` (empty = none do) would lie among the photos, and pass for some.
void keep_out_of_capture(const std::string& folder, const std::string& option, const PreparedBuild& prepared);

// Every option with its value, for report.json.
nlohmann::ordered_json options_json(const BuildSetup& setup, const BuildOptions& used);

}  // namespace ldp
