// A film written through ffmpeg, when that is installed.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>

#include "plane.h"

namespace ldp {

class Temporary;

class Film {
 public:
  // Starts ffmpeg on a temporary file beside `file`. Throws BadInput when there is no ffmpeg.
  Film(const std::filesystem::path& file, int width, int height);
  ~Film();  // without keep: nothing is left
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  void add(const RgbImage& picture);
  void keep();  // throws std::runtime_error when ffmpeg failed

 private:
  int close_and_wait();

  std::filesystem::path file_, partial_;
  std::unique_ptr<Temporary> temporary_;
  pid_t process_ = -1;
  int pipe_ = -1;
};

}  // namespace ldp
