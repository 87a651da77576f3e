#include "tests/bench/edges/slender_things.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/geometry/geometry.h"

namespace ldp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLongAsWide = 8;  // at least, of what is looked for
constexpr double kNearestZ = 0.3;  // metres
constexpr double kBorderPx = 8;    // of the view, that is left out
constexpr double kBesidePx = 2.5;  // from a thing's side to what is compared with it
constexpr double kStandsOut = 30;  // levels, by which it must differ from both of its sides
constexpr double kNothing = 1000;  // levels: a hole is like nothing
constexpr double kStepPx = 1;      // along a thing

using Levels = std::array<double, 3>;

double difference(const Levels& a, const Levels& b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

// Bilinear; within the picture.
Levels level_at(const RgbImage& picture, const Vector2d& at) {
  const int x = static_cast<int>(at.x() - 0.5), y = static_cast<int>(at.y() - 0.5);
  const double right = at.x() - 0.5 - x, below = at.y() - 0.5 - y;
  Levels sum{};
  for (const int j : {0, 1})
    for (const int i : {0, 1}) {
      const Rgb c = picture.at(x + i, y + j);
      const double share = (i != 0 ? right : 1 - right) * (j != 0 ? below : 1 - below);
      sum[0] += share * c.r, sum[1] += share * c.g, sum[2] += share * c.b;
    }
  return sum;
}

// One cylinder in one view.
class Walk {
 public:
  Walk(const Scene& scene, int object, const TrueView& truth, const View& rendering)
      : scene_(scene), object_(object), truth_(truth), rendering_(rendering) {}

  void run(SlenderLengths& lengths) {
    const Object& thing = scene_.description().objects[static_cast<size_t>(object_)];
    const Vector3d along = thing.half.z() * thing.world_from_local.col(2);
    Vector3d from = in_camera(thing.centre - along), to = in_camera(thing.centre + along);
    if (!clip(from, to) || !clip(to, from)) return;
    const Vector2d begin = at(from), end = at(to);
    const double length = (end - begin).norm();
    if (length < 1) return;
    const Vector2d aside = Vector2d(begin.y() - end.y(), end.x() - begin.x()) / length;
    long lost = 0;
    for (double s = kStepPx / 2; s < length; s += kStepPx) {
      // Even steps in the picture: inverse z is linear there.
      const double share = s / length, z = 1 / ((1 - share) / from.z() + share / to.z());
      const Vector2d place = begin + share * (end - begin);
      const double width = 2 * thing.half.x() * truth_.camera.intrinsics.fx / z;
      const std::optional<bool> stands = look(place, aside, width);
      if (!stands) {
        lost = 0;
        continue;
      }
      SlenderLength& of_width = lengths[class_of(width)];
      ++of_width.shown;
      of_width.standing += *stands ? 1 : 0;
      lost = *stands ? 0 : lost + 1;
      of_width.longest_break = std::max(of_width.longest_break, lost);
    }
  }

 private:
  Vector3d in_camera(const Vector3d& point) const {
    const Pose& pose = truth_.camera.pose;
    return pose.world_from_camera.transpose() * (point - pose.centre);
  }
  Vector2d at(const Vector3d& point) const { return project(truth_.camera.intrinsics, point); }

  // Moves `end` to where it lies before the camera. False where neither does.
  static bool clip(Vector3d& end, const Vector3d& other) {
    if (end.z() >= kNearestZ) return true;
    if (other.z() <= kNearestZ) return false;
    end += (kNearestZ - end.z()) / (other.z() - end.z()) * (other - end);
    return true;
  }

  static size_t class_of(double width) {
    size_t k = 0;
    while (k + 1 < kSlenderClasses && width >= kSlenderWidths[k + 1]) ++k;
    return k;
  }

  // Whether the thing stands at a place of its axis; nothing where the true view does not show it plainly.
  std::optional<bool> look(const Vector2d& place, const Vector2d& aside, double width) const {
    if (width < kSlenderWidths.front() || width >= kSlenderWidths.back() || !is_inside(place)) return {};
    const Vector3d ray = truth_.camera.pose.world_from_camera * unproject(truth_.camera.intrinsics, place);
    if (scene_.first_hit({truth_.camera.pose.centre, ray, 1 / truth_.camera.intrinsics.fx}).object != object_)
      return {};
    const Levels own = level_at(truth_.colour, place);
    const auto from_side = [&](double px) { return difference(own, level_at(truth_.colour, place + px * aside)); };
    const double beside = width / 2 + kBesidePx, contrast = std::min(from_side(beside), from_side(-beside));
    if (contrast < kStandsOut) return {};
    double closest = kNothing;
    for (const double px : {-1.0, 0.0, 1.0}) closest = std::min(closest, shown_difference(own, place + px * aside));
    return closest < contrast / 2;
  }

  bool is_inside(const Vector2d& place) const {
    return place.x() >= kBorderPx && place.y() >= kBorderPx && place.x() < truth_.colour.width - kBorderPx &&
           place.y() < truth_.colour.height - kBorderPx;
  }

  double shown_difference(const Levels& own, const Vector2d& place) const {
    if (rendering_.alpha.at(static_cast<int>(place.x()), static_cast<int>(place.y())) < 128) return kNothing;
    return difference(own, level_at(rendering_.colour, place));
  }

  const Scene& scene_;
  int object_;
  const TrueView& truth_;
  const View& rendering_;
};

bool is_slender(const Object& object) {
  return object.shape == Shape::cylinder && object.half.z() >= kLongAsWide * object.half.x();
}

}  // namespace

void SlenderLength::add(const SlenderLength& other) {
  shown += other.shown;
  standing += other.standing;
  longest_break = std::max(longest_break, other.longest_break);
}

SlenderLengths slender_lengths(const Scene& scene, const TrueView& truth, const View& rendering) {
  SlenderLengths lengths;
  const auto& objects = scene.description().objects;
  for (size_t i = 0; i < objects.size(); ++i)
    if (is_slender(objects[i])) Walk(scene, static_cast<int>(i), truth, rendering).run(lengths);
  return lengths;
}

}  // namespace ldp
