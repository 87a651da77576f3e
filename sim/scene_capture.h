// A synthetic sweep as a capture folder with truth, for `ldp scene` and the scene camera.
//
// Gives in the folder: frames/NNN.png and transforms.json, frames_depth/NNN.npy (float16, infinity = sky),
// novel/NNN.png, novel.json and novel_depth/NNN.npy, capture.json; around/panorama.png, stereo.png and distance.npy if
// asked for. Frames suffer from exposure drift, noise, blur and
// movement as asked; depths are exact for each frame's own moment, and novel views show the scene at rest and without
// people who walk by, as a perfect camera would.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/job.h"
#include "sim/scene/picture.h"
#include "sim/scene/surround.h"
#include "sim/scene/sweep_path.h"

namespace ldp {

struct SceneCaptureOptions {
  std::string scene = "courtyard";
  SweepPath path;
  double exposure_drift = 0;  // largest relative change of exposure over the sweep
  bool meters = false;        // automatic exposure, of novel views too
  double shade = 1;           // share of the light that half of the scene has, above 0
  double noise = 0;           // deviation in 8-bit levels
  double blur_px = 0;         // longest motion blur; every frame gets a random share of it
  double moving_share = 0;    // of figures and leaves, that move from frame to frame
  double crowd = 0;           // about the share of the fullest picture that people who walk by hide (crowd.h)
  uint32_t seed = 1;          // of the scene, the hand's jitter and the noise
  bool novel_views = true;
  SurroundOptions around;  // what is seen all around from the arc's centre; of width 0: it is left out
};

// Frames of a sweep, one by one.
class SceneSweep {
 public:
  explicit SceneSweep(const SceneCaptureOptions& options);

  const std::vector<Camera>& cameras() const { return cameras_; }
  double exposure(int frame) const;
  Picture take(int frame, const Job& job) const;
  const Scene& at_rest() const { return at_rest_; }

 private:
  SceneCaptureOptions options_;
  std::vector<Camera> cameras_;
  Scene at_rest_;
};

// Into a folder that exists. Throws std::invalid_argument (unknown scene), std::system_error (cannot be written),
// Cancelled.
void write_scene_capture(const SceneCaptureOptions& options, const std::filesystem::path& folder, const Job& job);

}  // namespace ldp
