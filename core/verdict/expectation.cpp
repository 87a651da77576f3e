#include "core/verdict/expectation.h"

#include <algorithm>
#include <cmath>

#include "core/base/exact_math.h"

namespace ldp {
namespace {

constexpr double kLn10 = 2.302585092994046, kLn2 = 0.6931471805599453;
constexpr double kMost_db = 60;
constexpr double kFloor_db = 14.5;        // of views that have nothing to do with the place
constexpr double kEvenGrey = 110;         // mean grey of a well exposed photograph
constexpr double kSharp = 0.27;           // blur of sharp photographs
constexpr double kUsualReprojection = 1;  // thousandths of the width
constexpr double kUsualShift = 0.27;      // widths
constexpr double kUsualParallax = 6e-3, kLeastParallax = 0.3e-3;
constexpr double kUsualOutward = 0.5;  // of an arc by a hand that also steps to and fro
constexpr double kUsualMismatch = 0.12, kMostMismatch = 2, kLittleTurn = 0.05;

// As features stand in `Feature`.
constexpr Features kWeights = {-0.6092, 0.6763,   -0.5850, 0.3398, -4.5252, -22.7755,
                               -2.7760, -14.9904, -3.8215, -11.47, -0.5681, -4.0932};

double hundredths(double x) { return std::round(x * 100) / 100; }

double decibels(double ratio) { return 10 * exact_log(ratio) / kLn10; }

double octaves(double ratio) { return exact_log(ratio) / kLn2; }

// Means over photographs, weighted by how many of their pixels lie in the portion that is judged.
struct Portion {
  DirectionEvidence pictures;
  double weight = 0, blur_x = 0, blur_y = 0, brightness = 0, detail = 0, shift = 0;

  void add(const SweepEvidence& evidence, size_t index, const DirectionEvidence& part) {
    const PhotoEvidence& photo = evidence.photos[index];
    const auto share = static_cast<double>(part.pixels);
    const size_t step = std::min(std::max<size_t>(index, 1), evidence.photos.size() - 1);  // the first has none
    pictures.add(part);
    weight += share;
    blur_x += share * photo.measures.blur_x;
    blur_y += share * photo.measures.blur_y;
    brightness += share * photo.measures.brightness;
    detail += share * photo.measures.detail;
    shift += share * evidence.photos[step].shift;
  }
};

double flatness(const SweepEvidence& evidence, const MotionMeasures& motion) {
  if (motion.parallax == 0 && evidence.motion != SweepMotion::rotation) return 0;
  return std::max(0.0, octaves(kUsualParallax / std::max(kLeastParallax, motion.parallax)));
}

Features features_from(const SweepEvidence& evidence, const Portion& portion) {
  const double weight = std::max(portion.weight, 1.0);
  const double back = psnr_of(portion.pictures.back);
  const bool beside = portion.pictures.neighbour.samples > 0;
  const MotionMeasures motion = motion_of(evidence);
  Features f{};
  at(f, Feature::one) = 1;
  at(f, Feature::back) = back;
  at(f, Feature::beside) = beside ? back - psnr_of(portion.pictures.neighbour) : 0;
  at(f, Feature::plain) = 2 * decibels(255 / std::max(portion.detail / weight, 0.5));
  at(f, Feature::dark) = std::max(0.0, octaves(kEvenGrey / std::max(portion.brightness / weight, 1.0)));
  at(f, Feature::blur) = std::max(0.0, std::max(portion.blur_x, portion.blur_y) / weight - kSharp);
  at(f, Feature::reprojection) = std::max(0.0, 1000 * evidence.reprojection - kUsualReprojection);
  at(f, Feature::shift) = std::max(0.0, portion.shift / weight - kUsualShift);
  at(f, Feature::flat) = flatness(evidence, motion);
  at(f, Feature::outward) = std::max(0.0, motion.outward - kUsualOutward);
  at(f, Feature::doubtful) = evidence.doubt != DoubtfulPoses::no ? 1 : 0;
  at(f, Feature::mismatch) = std::max(0.0, motion.mismatch - kUsualMismatch);
  return f;
}

}  // namespace

double exposure_jump(const SweepEvidence& evidence, size_t photo) {
  if (photo == 0) return 0;
  const double now = evidence.photos[photo].gain, before = evidence.photos[photo - 1].gain;
  return now > 0 && before > 0 ? std::abs(octaves(now / before)) : 0;
}

MotionMeasures motion_of(const SweepEvidence& evidence) {
  double outward = 0, all = 0, forward = 0, way = 0, squares = 0, shift = 0, turn = 0;
  int points = 0;
  for (size_t i = 1; i < evidence.photos.size(); ++i) {
    const PhotoEvidence& photo = evidence.photos[i];
    outward += photo.outward, all += photo.sideward;
    forward += photo.forward, way += photo.step;
    squares += photo.parallax_squares, points += photo.parallax_points;
    if (photo.far_shift <= 0) continue;
    shift += photo.far_shift;
    turn += photo.turn_deg / evidence.field_deg;
  }
  MotionMeasures motion;
  if (points > 0) motion.parallax = std::sqrt(squares / points);
  if (all > 0) motion.outward = std::abs(outward) / all;
  // Turns take most of a sideward step's flow with them, so that a little way forward outweighs it. Steps to and fro
  // lead nowhere.
  if (way > 0 && evidence.doubt == DoubtfulPoses::no)
    motion.outward = std::min(motion.outward, std::abs(forward) / way);
  motion.mismatch = std::min(kMostMismatch, std::abs(exact_log((shift + kLittleTurn) / (turn + kLittleTurn))));
  return motion;
}

Features features_of(const SweepEvidence& evidence) {
  Portion portion;
  for (size_t i = 0; i < evidence.photos.size(); ++i)
    for (const DirectionEvidence& part : evidence.photos[i].directions) portion.add(evidence, i, part);
  return features_from(evidence, portion);
}

Features features_of(const SweepEvidence& evidence, size_t direction) {
  Portion portion;
  for (size_t i = 0; i < evidence.photos.size(); ++i)
    portion.add(evidence, i, evidence.photos[i].directions[direction]);
  return features_from(evidence, portion);
}

double expected_view_psnr(const Features& features) {
  double sum = -kFloor_db;
  for (size_t i = 0; i < kFeatures; ++i) sum += kWeights[i] * features[i];
  const double above = sum > 30 ? sum : exact_log(1 + exact_exp(std::max(sum, -100.0)));
  return hundredths(std::min(kMost_db, kFloor_db + above));
}

double psnr_of(const SquaredError& error) {
  const double mean = error.mean();
  return mean > 0 ? hundredths(std::min(kMost_db, decibels(255.0 * 255.0 / mean))) : kMost_db;
}

}  // namespace ldp
