// A film written through ffmpeg, when that is installed: .mp4, .webm or .gif, in upper or lower case.
#pragma once

#include <filesystem>
#include <memory>

#include "core/base/plane.h"

namespace ldp {

class ChildProcess;
class Temporary;

bool names_a_film(const std::filesystem::path& file);

class Film {
 public:
  // Starts ffmpeg on a temporary file beside `file`. Throws BadInput when there is no ffmpeg.
  Film(const std::filesystem::path& file, int width, int height);
  ~Film();  // without keep: nothing is left
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  // Throw Impossible when ffmpeg failed, with what it said; MachineFault where that is a full disk, say.
  void add(const RgbImage& picture);
  void keep();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path file_, partial_;
  std::unique_ptr<Temporary> temporary_;
  std::unique_ptr<ChildProcess> ffmpeg_;
};

}  // namespace ldp
