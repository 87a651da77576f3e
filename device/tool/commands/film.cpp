#include "device/tool/commands/film.h"

#include <string>
#include <system_error>
#include <vector>

#include "core/base/files.h"
#include "core/base/job.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/process/child_process.h"
#include "device/tool/process/interrupt.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

std::vector<std::string> command_line(const std::filesystem::path& output, int width, int height) {
  std::vector<std::string> words = {"ffmpeg",   "-v",    "error",
                                    "-xerror",  // or it leaves half a film and calls that done
                                    "-nostdin", "-y",    "-f",    "rawvideo",
                                    "-pix_fmt", "rgb24", "-s",    std::to_string(width) + "x" + std::to_string(height),
                                    "-r",       "30",    "-i",    "pipe:0"};
  // Players want 4:2:0, which needs even sides.
  if (extension_of(output) != ".gif")
    words.insert(words.end(), {"-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p"});
  words.insert(words.end(), {"-metadata", std::string("comment=") + kRendered});  // a .gif has no room for it
  words.push_back(output.string());
  return words;
}

}  // namespace

bool names_a_film(const std::filesystem::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".mp4" || extension == ".webm" || extension == ".gif";
}

Film::Film(const std::filesystem::path& file, int width, int height) : file_(file) {
  partial_ = name_beside(file, ".partial-", file.extension().string());
  temporary_ = std::make_unique<Temporary>(partial_);
  try {
    ffmpeg_ = std::make_unique<ChildProcess>(command_line(partial_, width, height), ChildProcess::Pipe::to_child);
  } catch (const std::system_error&) {
    throw BadInput(file.string() +
                   ": films need ffmpeg, which could not be started: install it, or give a folder to -o");
  }
}

Film::~Film() {
  ffmpeg_->wait();
  std::error_code ignored;
  if (!partial_.empty()) std::filesystem::remove(partial_, ignored);
}

void Film::add(const RgbImage& picture) {
  static_assert(sizeof(Rgb) == 3);
  const auto* bytes = reinterpret_cast<const uint8_t*>(picture.samples.data());
  if (!ffmpeg_->write({bytes, 3 * picture.samples.size()})) fail();
}

// By the first line that ffmpeg said, which gives the cause, with the film's own name.
void Film::fail() const {
  ffmpeg_->wait();
  std::string said = ffmpeg_->first_line_said();
  if (const auto fault = machine_fault_in(said))
    throw MachineFault("cannot write " + file_.string() + ": " + fault->message());
  const std::string partial = partial_.string();
  if (const size_t at = said.find(partial); at != std::string::npos) said.replace(at, partial.size(), file_.string());
  throw Impossible(file_.string() + ": ffmpeg failed" + (said.empty() ? "" : ": " + said));
}

void Film::keep() {
  if (ffmpeg_->wait() != 0 || machine_fault_in(ffmpeg_->first_line_said())) fail();
  const Finishing finishing;
  move_file(partial_, file_);
  partial_.clear();
}

}  // namespace ldp
