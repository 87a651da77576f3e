// Camera poses from photographs (structure from motion for an arm's-length sweep; paper section 4).
//
// Takes frames; gives cameras (shared intrinsics with radial distortion), sparse points and a report. The world of the
// estimated poses has its up axis along +z, and its scale such that the cameras' circle has `arm_length` as radius.
// How: features per frame, matching of neighbours and loop closures, initialisation from outward-looking circular
// motion, bundle adjustment. Does not fit the final arc (arc.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/geometry/camera_motion.h"
#include "core/geometry/geometry.h"
#include "core/photos/frame_source.h"
#include "core/photos/left_out.h"

namespace ldp {

struct PosesOptions {
  std::optional<double> fov_rad;  // horizontal field of view of the photos if known roughly; else EXIF; else estimated
  double arm_length = 0.65;       // radius given to the cameras' circle, capture's unit (metres)
  unsigned seed = 1;              // of every random choice
  friend bool operator==(const PosesOptions&, const PosesOptions&) = default;
};

struct FrameReport {
  std::string name;
  bool posed = false;
  int features = 0, matches = 0, inliers = 0;
  double reprojection_px = 0;  // root mean square over the frame's inliers
  LeftOut left_out;            // why it has no pose; none when posed
};

// Why poses may be wrong though their points fit.
enum class PoseDoubt : uint8_t {
  none,
  contradicted,  // matches disagree with them: something repeats itself or moves
  unrelated,     // photos that should show the same have nothing in common
  loose,         // hardly any points tie some photos together
  in_pairs,      // hardly any point is seen in three photos
  lens           // they are those of a lens that hardly any camera has
};

struct PosesReport {
  Motion motion = Motion::arc;
  bool closed = false;  // the sweep closes on itself
  std::vector<FrameReport> frames;
  double reprojection_px = 0;  // root mean square over all inliers
  int points = 0;
  double agreement =
      1;  // share of the verified matches of neighbouring photos that fit the poses; 1 if cameras are told
  PoseDoubt doubt_kind = PoseDoubt::none;
  std::string doubt;      // the same in words, naming photos; empty when nothing says so
  double told_focal = 1;  // focal length that options or EXIF tell, of that found; 1 where they tell none, and where
                          // one of another lens was kept to, since nothing better was found without it
  bool told_by_exif = false;
};

struct Poses {
  std::vector<Camera> cameras;       // posed frames only, in frame order, named after their frames
  std::vector<int> frame_of_camera;  // index in the FrameSource of each camera
  std::vector<ScenePoint> points;
  std::vector<std::vector<Eigen::Vector2d>> sightings;  // of each point in its cameras, pixels
  PosesReport report;
};

// What to say where options or EXIF spoke of another lens or another crop than the photos show; empty where not.
std::string wrong_lens(const Poses& poses);

// Throws Impossible when fewer than 3 frames can be connected, naming the reason.
Poses estimate_poses(const FrameSource& frames, const PosesOptions& options, const Job& job);

// The same while the capture runs: features are found and matched as frames arrive, `finish` does what remains. Gives
// the same bytes as estimate_poses of the same frames. After an exception it can only be destroyed or assigned to.
class PoseEstimator {
 public:
  explicit PoseEstimator(const PosesOptions& options);
  PoseEstimator(PoseEstimator&&) noexcept;
  PoseEstimator& operator=(PoseEstimator&&) noexcept;
  ~PoseEstimator();

  // Has the first `count` frames of the source afterwards: adds what is new, and begins anew if it had any others.
  void add_frames(const FrameSource& source, int count, const Job& job);
  int size() const;
  const PosesOptions& options() const;
  Poses finish(const Job& job) const;  // throws as estimate_poses does

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Of all frames of the source, some of which `begun` may have.
Poses estimate_poses(const FrameSource& frames, PoseEstimator begun, const Job& job);

// The same points and report for cameras that are already known (matched to frames by name; frames without a camera
// are reported as left out). Cameras are left exactly as given. Throws Impossible when fewer than 3 names match,
// std::runtime_error when the photos tell that y and z of the cameras' axes are turned round.
Poses triangulate(const FrameSource& frames, const std::vector<Camera>& cameras, const PosesOptions& options,
                  const Job& job);

// Takes those cameras out that are left out by `why`, one for each camera, and points that fewer than two others see.
void leave_out(const std::vector<LeftOut>& why, Poses& poses);

}  // namespace ldp
