#include "sim/scene/crowd.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/geometry.h"
#include "sim/scene/random.h"
#include "sim/scene/scene_builder.h"
#include "sim/scene/scene_things.h"

namespace ldp {

using namespace scene;

namespace {

constexpr double kNearest = 1.2, kFarthest = 4;  // metres beyond the arm
constexpr double kFastest = 0.45;                // metres a frame
constexpr double kStep = 0.7;                    // metres
constexpr double kTall = 1.75, kWide = 0.5;      // metres
constexpr double kFilledShare = 0.5;             // of a box as tall and wide, that someone fills
constexpr int kCandidates = 300;                 // of whom those join that no picture is too full for

struct Walker {
  double distance = 0;  // metres from the axis that all walk round
  double azimuth = 0;   // at the first frame, growing anticlockwise, radians
  double pace = 0;      // metres a frame, anticlockwise
  double phase = 0;     // of the first step, radians
  uint32_t looks = 0;   // seed

  double azimuth_at(int frame) const { return azimuth + frame * pace / distance; }
};

Walker make_walker(const SweepPath& path, bool follows, Random& random) {
  Walker walker;
  walker.distance = path.radius + random.uniform(kNearest, kFarthest);
  walker.azimuth = random.uniform(0, kFullTurn);
  walker.phase = random.uniform(0, kFullTurn);
  walker.looks = static_cast<uint32_t>(random.bits());
  const double keeps_up = walker.distance * path.arc_rad / std::max(1, path.frames - 1);  // cameras turn clockwise
  walker.pace = follows ? -std::min(kFastest, random.uniform(0.5, 1) * keeps_up) : random.uniform(-kFastest, kFastest);
  return walker;
}

// The share of a camera's picture that one hides, as if it were level.
double hidden_share(const Walker& walker, int frame, const Camera& camera) {
  const Eigen::Vector3d away =
      polar(walker.azimuth_at(frame), walker.distance, camera.pose.centre.z()) - camera.pose.centre;
  const double ahead = away.dot(camera.pose.world_from_camera.col(2)),
               aside = away.dot(camera.pose.world_from_camera.col(0));
  if (ahead < 0.5) return 0;
  // Of the picture, by a side of the box that goes from here to there, metres.
  const auto shown = [ahead](double from, double to, double half_px, double focal) {
    const double half = ahead * half_px / focal;
    return std::max(0.0, std::min(to, half) - std::max(from, -half)) / (2 * half);
  };
  const Intrinsics& k = camera.intrinsics;
  const double eye = camera.pose.centre.z();
  return kFilledShare * shown(aside - 0.5 * kWide, aside + 0.5 * kWide, 0.5 * k.width, k.fx) *
         shown(-eye, kTall - eye, 0.5 * k.height, k.fy);
}

std::vector<Walker> crowd(const SweepPath& path, double share, uint32_t seed) {
  const std::vector<Camera> cameras = sweep_cameras(path);
  std::vector<double> hidden(cameras.size(), 0);
  std::vector<Walker> walkers;
  Random random(mix_bits(seed) + 17);
  for (int i = 0; i < kCandidates; ++i) {
    const Walker walker = make_walker(path, walkers.size() % 4 == 0, random);
    std::vector<double> with = hidden;
    for (size_t frame = 0; frame < cameras.size(); ++frame)
      with[frame] += hidden_share(walker, static_cast<int>(frame), cameras[frame]);
    if (*std::max_element(with.begin(), with.end()) > share) continue;
    hidden = with;
    walkers.push_back(walker);
  }
  return walkers;
}

}  // namespace

SceneDescription with_crowd(SceneDescription scene, const SweepPath& path, double share, int frame, uint32_t seed) {
  if (share <= 0) return scene;
  for (const Walker& walker : crowd(path, share, seed)) {
    SceneBuilder builder(walker.looks);
    const double azimuth = walker.azimuth_at(frame), facing = azimuth + (walker.pace < 0 ? -0.25 : 0.25) * kFullTurn;
    figure(builder, polar(azimuth, walker.distance, 0), facing,
           walker.phase + 0.5 * kFullTurn * frame * walker.pace / kStep);
    scene.objects.insert(scene.objects.end(), builder.scene.objects.begin(), builder.scene.objects.end());
  }
  return scene;
}

}  // namespace ldp
