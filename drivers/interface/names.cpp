// The words for the enumerations of the interfaces.
#include <array>

#include "drivers/interface/camera.h"
#include "drivers/interface/status.h"

namespace ldp {
namespace {

template <size_t count, typename Enum>
const char* word_of(const std::array<const char*, count>& words, Enum value) {
  const auto index = static_cast<size_t>(value);
  return index < count ? words[index] : "unknown";
}

}  // namespace

const char* name_of(PixelFormat format) {
  return word_of(std::array{"mjpeg", "yuyv", "nv12", "rgb24", "bgr24"}, format);
}
const char* name_of(Phase phase) {
  return word_of(std::array{"idle", "capturing", "building", "done", "failed"}, phase);
}
const char* name_of(Advice advice) {
  return word_of(std::array{"keep going", "slower", "faster", "level", "too dark", "turn back", "done"}, advice);
}
const char* name_of(Judgement judgement) {
  return word_of(std::array{"not judged", "good", "fair", "sweep again"}, judgement);
}
const char* name_of(Command command) {
  return word_of(std::array{"press", "release", "cancel", "retry", "stop"}, command);
}

}  // namespace ldp
