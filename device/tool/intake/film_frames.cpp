#include "device/tool/intake/film_frames.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/photos/images.h"
#include "device/capture/frame_pixels.h"
#include "device/capture/frame_selection.h"
#include "device/tool/intake/intake_tuning.h"
#include "device/tool/process/child_process.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

// Pictures as .ppm files one after the other, which tell their size. Of other files than this one nothing is read, as
// playlists would have it.
std::vector<std::string> command_line(const fs::path& film, int64_t max_pixels) {
  const std::string shrink = "min(1\\,sqrt(" + std::to_string(max_pixels) + "/(iw*sar*ih)))";
  return {"ffmpeg",
          "-v",
          "error",
          "-nostdin",
          "-threads",
          "2",
          "-protocol_whitelist",
          "file",
          "-i",
          "file:" + fs::absolute(film).string(),
          "-map",
          "0:v:0",
          "-an",
          "-sn",
          "-dn",
          "-vf",
          "scale=w=trunc(iw*sar*" + shrink + "):h=trunc(ih*" + shrink + "):flags=area,setsar=1",
          "-f",
          "image2pipe",
          "-c:v",
          "ppm",
          "-pix_fmt",
          "rgb24",
          "pipe:1"};
}

class FilmPictures {
 public:
  FilmPictures(const fs::path& film, int64_t max_pixels, const Job& job)
      : film_(film),
        max_pixels_(max_pixels),
        job_(job),
        ffmpeg_(command_line(film, max_pixels), ChildProcess::Pipe::from_child, kDecoderMemory_bytes) {}

  // False at the end of the film.
  bool next(RgbImage& picture) {
    const ImageSize size = next_size();
    if (size.width == 0) return false;
    if (picture.width != size.width || picture.height != size.height) picture = RgbImage(size.width, size.height);
    const size_t bytes = 3 * picture.samples.size();
    if (ffmpeg_.read({reinterpret_cast<uint8_t*>(picture.samples.data()), bytes}, job_) < bytes) refuse();
    return true;
  }

 private:
  [[noreturn]] void refuse() {
    ffmpeg_.end();
    const std::string words = ffmpeg_.first_line_said();
    throw BadInput(film_.string() +
                   ": neither a folder of photos, a photo, a .zip archive nor a film that ffmpeg reads" +
                   (words.empty() ? "" : " (" + words + ")") + ": check the name");
  }

  // Of the header "P6\nWIDTH HEIGHT\n255\n"; none at the end of the film.
  ImageSize next_size() {
    std::string header;
    uint8_t byte = 0;
    for (int lines = 0; lines < 3;) {
      if (ffmpeg_.read({&byte, 1}, job_) == 0) break;
      header += static_cast<char>(byte);
      lines += byte == '\n' ? 1 : 0;
      constexpr size_t kLongestHeader = 64;
      if (header.size() > kLongestHeader) refuse();
    }
    if (header.empty() && begun_ && ffmpeg_.wait() == 0) return {};
    ImageSize size;
    if (std::sscanf(header.c_str(), "P6\n%7d %7d\n255\n", &size.width, &size.height) != 2) refuse();
    if (size.width < 1 || size.height < 1 || int64_t{size.width} * size.height > max_pixels_) refuse();
    begun_ = true;
    return size;
  }

  const fs::path& film_;
  int64_t max_pixels_;
  const Job& job_;
  ChildProcess ffmpeg_;
  bool begun_ = false;
};

std::string frame_name(int index) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "frame_%03d.jpg", index);
  return name.data();
}

CameraFrame frame_of(const RgbImage& picture, int64_t time_ns) {
  CameraFrame frame;
  frame.time_ns = time_ns;
  frame.format = PixelFormat::rgb24;
  frame.width = picture.width;
  frame.height = picture.height;
  frame.planes.push_back(
      {reinterpret_cast<const uint8_t*>(picture.samples.data()), 3 * picture.samples.size(), 3 * picture.width});
  return frame;
}

class FilmChoice {
 public:
  FilmChoice(const UnpackedFolder& to, const ChooserOptions& options) : to_(to), chooser_(options) {}

  void offer(RgbImage& picture) {
    const auto time_ns = static_cast<int64_t>(seen_++ * 1e9 / kFilmRate);
    const CameraFrame frame = frame_of(picture, time_ns);
    const Verdict verdict = chooser_.offer({thumbnail(frame), sharpness(frame), time_ns, std::nullopt});
    if (verdict.store_held) store(held_);
    if (verdict.store_this) store(picture);
    if (verdict.hold_this) std::swap(held_, picture);
  }
  void finish() {
    if (chooser_.finish()) store(held_);
  }
  bool full() const { return chooser_.full(); }
  int seen() const { return seen_; }
  int stored() const { return stored_; }

 private:
  void store(const RgbImage& picture) { to_.put(frame_name(stored_++), encode_jpeg(picture, kFilmJpegQuality)); }

  const UnpackedFolder& to_;
  FrameChooser chooser_;
  RgbImage held_;
  int seen_ = 0, stored_ = 0;
};

struct Taken {
  int pictures = 0, chosen = 0;
};

Taken take_frames(const fs::path& film, const UnpackedFolder& to, int64_t max_pixels, const ChooserOptions& options,
                  const Job& job) {
  FilmPictures pictures(film, max_pixels, job);
  FilmChoice choice(to, options);
  RgbImage picture;
  ImageSize size;
  while (!choice.full() && pictures.next(picture)) {
    if (choice.seen() == 0) size = {picture.width, picture.height};
    if (ImageSize{picture.width, picture.height} != size)
      throw BadInput(film.string() + ": its pictures change their size: cut out the part that shows one sweep");
    if (choice.seen() >= kMaxFilmPictures)
      throw BadInput(film.string() + ": is longer than " + std::to_string(kMaxFilmPictures) +
                     " pictures: cut out the part that shows one sweep");
    choice.offer(picture);
    job.check();
  }
  choice.finish();
  return {choice.seen(), choice.stored()};
}

// Of neighbours, at which kWantedFilmFrames span what `chosen` frames did.
double overlap_for_more(int chosen) {
  return std::min(kMostFilmOverlap, 1 - (1 - kFilmOverlap) * (chosen - 1) / (kWantedFilmFrames - 1));
}

}  // namespace

void take_film_frames(const fs::path& film, const UnpackedFolder& to, const FilmOptions& options, const Job& job) {
  job.report("unpacking", 0);
  ChooserOptions chooser;
  chooser.overlap = kFilmOverlap;
  chooser.max_frames = kMaxFilmFrames;
  if (options.fov_rad) chooser.fov_rad = *options.fov_rad;
  try {
    const auto [pictures, chosen] = take_frames(film, to, options.max_pixels, chooser, job);
    const bool still = chosen < 2;  // what shows one place is told so, not looked at more closely
    if (still || chosen >= kFewFilmFrames || chosen == pictures) return;
    chooser.overlap = overlap_for_more(chosen);
    const int more = take_frames(film, to, options.max_pixels, chooser, job).chosen;
    for (int i = more; i < chosen; ++i) fs::remove(to.path() / frame_name(i));
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::no_such_file_or_directory) throw;
    throw BadInput(film.string() +
                   ": films need ffmpeg, which could not be started: install it, or give a folder of photos");
  }
}

}  // namespace ldp
