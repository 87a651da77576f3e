// Frames of a film as photos of a sweep, through ffmpeg where that is installed: chosen by overlap and sharpness as a
// device chooses those of its camera (device/capture/frame_selection.h), turned as the film says. A film that turns so
// little that few are chosen is gone through again, for more of them.
//
// Pictures come from ffmpeg one after the other; two are held at a time, and those chosen are JPEG files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/base/job.h"
#include "device/tool/intake/unpacked_folder.h"

namespace ldp {

struct FilmOptions {
  int64_t max_pixels = 2'100'000;  // of a frame; larger pictures are made smaller
  std::optional<double> fov_rad;   // horizontal
};

// Into files frame_000.jpg and so on. Throws BadInput naming the film: ffmpeg is not there, or cannot read it, or it
// is longer than intake_tuning.h allows.
void take_film_frames(const std::filesystem::path& film, const UnpackedFolder& to, const FilmOptions& options,
                      const Job& job);

}  // namespace ldp
