// What is known of a sweep and of its panorama when it is judged. Angles are degrees of turn from the first
// photograph's heading, in the direction of the sweep; photographs are in the order of the sweep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/verdict/photo_measures.h"

namespace ldp {

enum class SweepMotion : uint8_t { arc, straight, rotation };

// Why, where the poses are: what matches contradicts them, too little ties them together, or the lens is no lens.
enum class DoubtfulPoses : uint8_t { no, contradicted, loose, lens };

// Squared differences of colours (R, G and B each counted) over some pixels.
struct SquaredError {
  int64_t sum = 0, samples = 0;
  void add(const SquaredError& other) { sum += other.sum, samples += other.samples; }
  double mean() const { return samples > 0 ? static_cast<double>(sum) / static_cast<double>(samples) : 0; }
};

// Of the pixels of one photograph that lie in one direction.
struct DirectionEvidence {
  int64_t pixels = 0, holes = 0;
  int64_t compared = 0, unexplained = 0;  // pixels that are no holes; those that no colour of the panorama comes near
  SquaredError back;                      // the panorama rendered into the photograph, holes mid-grey
  SquaredError neighbour;                 // what the photograph beside it shows of the panorama's surfaces there
  void add(const DirectionEvidence& other);
};

struct PhotoEvidence {
  double heading_deg = 0;
  // Of the camera since the photograph before, by its poses: turn, way, part of it along the line of sight (negative
  // backward).
  double turn_deg = 0, step = 0, forward = 0;
  PhotoMeasures measures;
  double gain = 1;  // factor of green that brings it to the exposure of all
  // Of the points that it shares with the photograph before.
  int shared_points = 0;
  double shift = 0;      // mean, in widths of the photograph
  double far_shift = 0;  // of the farthest of them
  // Of what turns leave of their flow, in normalised image positions: parts away from the middle, lengths, squares.
  double outward = 0, sideward = 0, parallax_squares = 0;
  int parallax_points = 0;
  std::vector<DirectionEvidence> directions;  // every kDirection_deg from the sweep's first_deg on
};

constexpr double kDirection_deg = 15;
constexpr int kFullTurn = static_cast<int>(360 / kDirection_deg);  // directions of a sweep that goes all the way round

struct SweepEvidence {
  SweepMotion motion = SweepMotion::arc;
  DoubtfulPoses doubt = DoubtfulPoses::no;
  int photos_taken = 0;               // posed or not, but for those that show what others show
  double field_deg = 0;               // horizontal field of view
  double reprojection = 0;            // root mean square, in longer sides of the photograph
  double inward = 0;                  // 0 .. 1: how much cameras that turn move against where they look
  double agreement = 1;               // share of the matches of neighbouring photographs that fit the poses
  double first_deg = 0;               // where the first direction begins
  std::vector<PhotoEvidence> photos;  // posed ones
};

// By how much the exposure changes from the photograph before, factors of two.
double exposure_jump(const SweepEvidence& evidence, size_t photo);

}  // namespace ldp
