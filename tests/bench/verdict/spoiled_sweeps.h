// Sweeps of synthetic scenes, good ones and the same spoiled in one way, in memory, with true views to judge them by.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/geometry/geometry.h"
#include "core/photos/frame_source.h"
#include "core/pipeline/build.h"

namespace ldp {

enum class Spoil : uint8_t {
  none,
  motion_blur,
  half_dropped,
  two_thirds_dropped,
  dark_noisy,
  wrong_lens,
  walking_forward,
  standing_still,
  exposures_jump,
  crowd,
  two_sweeps
};
inline constexpr std::array kSpoils = {
    Spoil::none,           Spoil::motion_blur, Spoil::half_dropped,    Spoil::two_thirds_dropped,
    Spoil::dark_noisy,     Spoil::wrong_lens,  Spoil::walking_forward, Spoil::standing_still,
    Spoil::exposures_jump, Spoil::crowd,       Spoil::two_sweeps};
const char* name_of(Spoil spoil);

class PicturesInMemory final : public FrameSource {
 public:
  void add(std::string name, RgbImage picture);
  int size() const override { return static_cast<int>(pictures_.size()); }
  std::string name(int index) const override { return names_[static_cast<size_t>(index)]; }
  RgbImage load(int index) const override { return pictures_[static_cast<size_t>(index)]; }
  std::optional<double> focal_hint(int) const override { return {}; }

 private:
  std::vector<std::string> names_;
  std::vector<RgbImage> pictures_;
};

struct TrueView {
  Camera camera;
  RgbImage picture;
};

struct SyntheticSweep {
  std::string scene;
  uint32_t seed = 0;
  Spoil spoil = Spoil::none;
  PicturesInMemory frames;
  std::vector<Camera> cameras;  // true ones of the frames that belong to the sweep
  std::vector<TrueView> views;
  BuildOptions options;  // what the device would be told of the lens
};

// Everything about the sweep is drawn from the seed: scene, lens, path, how much it is spoiled.
SyntheticSweep make_sweep(uint32_t seed, Spoil spoil, const Job& job);

}  // namespace ldp
