// How good a panorama's new views will be, and why not better: the verdict on a sweep.
//
// Angles are degrees of turn from the heading of the sweep's first photograph, in the direction of the sweep.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ldp {

enum class Grade : uint8_t { good, fair, sweep_again };

// Numbers are stored in files: new reasons come last.
enum class QualityReason : uint8_t {
  blurred,          // photographs smeared by motion or out of focus
  dark,             // little light: noise, and dark colours that no exposure brings back
  little_overlap,   // neighbouring photographs share too little
  no_parallax,      // the camera turned without moving
  moved_forward,    // along its line of sight
  moved_straight,   // along a line instead of round an arc
  poses_doubtful,   // photographs contradict the poses found
  photos_left_out,  // by the poses
  exposure_jumps,   // from photograph to photograph
  contradicted,     // photographs show other things than the panorama: they moved, or were not understood
  holes,            // places that no photograph shows
  lens_doubtful,    // photographs do not fit the lens told or found
  looked_inward     // the camera went around a thing that it looked at
};
constexpr int kQualityReasons = 13;

constexpr double kTurn_deg = 360;

struct QualityFinding {
  QualityReason reason = QualityReason::blurred;
  double from_deg = 0, to_deg = 0;  // where; from_deg <= to_deg, which is beyond the turn where it lies across the join
  friend bool operator==(const QualityFinding&, const QualityFinding&) = default;
};

struct DirectionQuality {
  double from_deg = 0, to_deg = 0;
  Grade grade = Grade::good;
  double expected_view_psnr_db = 0, photos_back_psnr_db = 0, unexplained_share = 0;
  friend bool operator==(const DirectionQuality&, const DirectionQuality&) = default;
};

struct SweepQuality {
  Grade grade = Grade::good;
  std::vector<QualityFinding> reasons;  // the weightiest first; none when nothing is wrong
  double expected_view_psnr_db = 0;     // of new views from within the arm's reach, exposure matched
  double photos_back_psnr_db = 0;       // of the panorama rendered into its own photographs
  double unexplained_share = 0;         // of the photographs' pixels, 0 .. 1
  std::vector<DirectionQuality> by_direction;
  friend bool operator==(const SweepQuality&, const SweepQuality&) = default;
};

// To and from the figures by name that a file keeps (core/panorama/file/FORMAT.md, "qual"). None when figures are
// missing or are none that `figures_of` gives.
std::map<std::string, double> figures_of(const SweepQuality& quality);
std::optional<SweepQuality> quality_from(const std::map<std::string, double>& figures);

// Whether a figure of that name belongs to the verdict.
bool is_of_verdict(const std::string& name);

}  // namespace ldp
