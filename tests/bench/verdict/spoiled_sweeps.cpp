#include "tests/bench/verdict/spoiled_sweeps.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "sim/scene/picture.h"
#include "sim/scene/random.h"
#include "sim/scene/scenes.h"
#include "sim/scene/sweep_path.h"

namespace ldp {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kEdgeSamples = 2;

struct Plan {
  std::string scene;
  SweepPath path;
  bool lens_is_told = true;
};

Plan plan_of(uint32_t seed) {
  Random random(mix_bits(seed) + 77);
  Plan plan;
  plan.scene = scene_names()[static_cast<size_t>(random.below(static_cast<int>(scene_names().size())))];
  plan.path.width = 256, plan.path.height = 192;
  plan.path.frames = 12 + random.below(3);
  plan.path.fov_rad = random.uniform(52, 66) * kDegree;
  plan.path.arc_rad = (plan.path.frames - 1) * plan.path.fov_rad * random.uniform(0.17, 0.25);
  plan.path.radius = random.uniform(0.5, 0.75);
  plan.path.seed = seed;
  plan.lens_is_told = random.below(2) == 0;
  return plan;
}

// A walk into the scene, turning a little, as long as the clean sweep's arc; views are those beside its path.
std::vector<Camera> walk(const SweepPath& path, bool views) {
  Random random(mix_bits(path.seed) + 5);
  std::vector<Camera> cameras = views ? novel_cameras(path) : sweep_cameras(path);
  const double length = random.uniform(0.6, 1.5), turn = random.uniform(-25, 25) * kDegree;
  const auto count = static_cast<double>(cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    const double share = static_cast<double>(i) / (count - 1) - 0.5;
    const double theta = std::numbers::pi / 2 + turn * share;
    const Eigen::Vector3d forward{std::cos(theta), std::sin(theta), 0}, down{0, 0, -1};
    Pose& pose = cameras[i].pose;
    pose.centre = Eigen::Vector3d(0, length * share, path.eye_height) +
                  path.position_jitter * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    pose.world_from_camera << down.cross(forward), down, forward;
    const double aside = random.uniform(-1, 1);
    if (views) pose.centre += 0.25 * aside * pose.world_from_camera.col(0);
  }
  return cameras;
}

std::vector<Camera> on_the_spot(const SweepPath& path) {
  SweepPath still = path;
  still.radius = 0;
  still.position_jitter = 0.002;
  return sweep_cameras(still);
}

class Photographer {
 public:
  Photographer(const Plan& plan, uint32_t seed, Spoil spoil, const Job& job)
      : plan_(plan),
        spoil_(spoil),
        seed_(seed),
        random_(mix_bits(seed) + 900 + static_cast<uint64_t>(spoil)),
        job_(job),
        scene_(make_scene(plan.scene, seed)),
        strength_(random_.uniform()) {}

  RgbImage take(const Camera& camera, int index) {
    PictureOptions picture;
    picture.edge_samples = kEdgeSamples;
    picture.noise = 1.5;
    picture.noise_seed = random_.bits();
    const double chance = random_.uniform(-1, 1);
    switch (spoil_) {
      case Spoil::motion_blur:
        picture.motion_blur_px = (4 + 14 * strength_) * (0.4 + 0.6 * std::abs(chance));
        break;
      case Spoil::dark_noisy:
        picture.exposure = 0.25 - 0.17 * strength_;
        picture.noise = 4 + 6 * strength_;
        break;
      case Spoil::exposures_jump:
        picture.exposure = std::exp2((0.7 + 1.1 * strength_) * chance);
        break;
      default:
        break;
    }
    if (spoil_ != Spoil::crowd) return take_picture(scene_, camera, picture, job_).colour;
    const double share = 0.4 + 0.6 * strength_;
    const Scene moment(moved(scene_.description(), share, index, seed_));
    return take_picture(moment, camera, picture, job_).colour;
  }

  RgbImage true_view(const Camera& camera) const {
    return take_picture(scene_, camera, {.edge_samples = kEdgeSamples}, job_).colour;
  }
  double strength() const { return strength_; }

 private:
  const Plan& plan_;
  Spoil spoil_;
  uint32_t seed_;
  Random random_;
  const Job& job_;
  Scene scene_;
  double strength_;  // 0 .. 1, of what spoils the sweep
};

bool is_kept(Spoil spoil, size_t index) {
  if (spoil == Spoil::half_dropped) return index % 2 == 0;
  if (spoil == Spoil::two_thirds_dropped) return index % 3 == 0;
  return true;
}

// Another place's photographs from some frame on, as when two sweeps end up in one folder.
void mix_in_another(SyntheticSweep& sweep, const Plan& plan, double strength, const Job& job) {
  Plan other = plan_of(sweep.seed + 5000);
  other.path.fov_rad = plan.path.fov_rad;
  Photographer photographer(other, sweep.seed + 5000, Spoil::none, job);
  const std::vector<Camera> cameras = sweep_cameras(other.path);
  const int count = sweep.frames.size();
  const int strangers = std::max(3, static_cast<int>((0.25 + 0.3 * strength) * count));
  for (int i = 0; i < strangers && i < static_cast<int>(cameras.size()); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "%03d.png", count + i);
    sweep.frames.add(name, photographer.take(cameras[static_cast<size_t>(i)], i));
  }
}

// The wrong field of view, or cameras whose poses are true and whose lens is another's.
void tell_lens(SyntheticSweep& sweep, const Plan& plan, double strength) {
  if (plan.lens_is_told) sweep.options.poses.fov_rad = plan.path.fov_rad;
  if (sweep.spoil != Spoil::wrong_lens) return;
  const double zoom = strength < 0.5 ? 0.6 + 0.5 * strength : 1.1 + 0.4 * strength;
  if (plan.lens_is_told) {
    sweep.options.poses.fov_rad = plan.path.fov_rad / zoom;
  } else {
    sweep.options.cameras = sweep.cameras;
    for (Camera& camera : sweep.options.cameras) camera.intrinsics.fx *= zoom, camera.intrinsics.fy *= zoom;
  }
}

}  // namespace

const char* name_of(Spoil spoil) {
  constexpr std::array kNames = {"clean",   "blur",  "half",  "third", "dark", "lens",
                                 "forward", "still", "jumps", "crowd", "mixed"};
  return kNames[static_cast<size_t>(spoil)];
}

void PicturesInMemory::add(std::string name, RgbImage picture) {
  names_.push_back(std::move(name));
  pictures_.push_back(std::move(picture));
}

SyntheticSweep make_sweep(uint32_t seed, Spoil spoil, const Job& job) {
  const Plan plan = plan_of(seed);
  SyntheticSweep sweep;
  sweep.scene = plan.scene, sweep.seed = seed, sweep.spoil = spoil;
  Photographer photographer(plan, seed, spoil, job);
  std::vector<Camera> path = spoil == Spoil::walking_forward  ? walk(plan.path, false)
                             : spoil == Spoil::standing_still ? on_the_spot(plan.path)
                                                              : sweep_cameras(plan.path);
  for (size_t i = 0; i < path.size(); ++i) {
    if (!is_kept(spoil, i)) continue;
    sweep.frames.add(path[i].name, photographer.take(path[i], static_cast<int>(i)));
    sweep.cameras.push_back(path[i]);
  }
  for (const Camera& camera : spoil == Spoil::walking_forward ? walk(plan.path, true) : novel_cameras(plan.path))
    sweep.views.push_back({camera, photographer.true_view(camera)});
  if (spoil == Spoil::two_sweeps) mix_in_another(sweep, plan, photographer.strength(), job);
  tell_lens(sweep, plan, photographer.strength());
  return sweep;
}

}  // namespace ldp
