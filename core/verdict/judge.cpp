#include "core/verdict/judge.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/verdict/expectation.h"

namespace ldp {
namespace {

constexpr double kNoiseGrey = 118;   // noise is told at it: mean grey of a well exposed photograph
constexpr double kRounding = 0.5;    // levels of noise that rounding hides
constexpr double kLeastSeen = 0.02;  // share of a photograph's pixels from which a direction is judged
constexpr double kSharpest = 0.2;    // blur of a photograph of sharp edges that are not close together

struct Found {
  QualityFinding finding;
  Grade grade = Grade::fair;
  double weight = 0;  // how far beyond its bound, of several reasons
};

// Blur of one axis beyond that of the other. Fine lines along one axis look sharper than anything is: the blurred axis
// has to be so by itself.
double smear_of(const PhotoMeasures& photo) {
  return std::min(std::abs(photo.blur_x - photo.blur_y), std::max(photo.blur_x, photo.blur_y) - kSharpest);
}

// So many of the values are less, or as large.
double ranked(std::vector<double> values, size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

class Judge {
 public:
  Judge(const SweepEvidence& evidence, const JudgeOptions& options) : evidence_(evidence), options_(options) {}

  SweepQuality judge_sweep() {
    find();
    SweepQuality quality;
    add_findings(quality);
    return quality;
  }

  SweepQuality judge() {
    find();
    SweepQuality quality;
    quality.expected_view_psnr_db = expected_view_psnr(features_of(evidence_));
    const DirectionEvidence all = everything();
    quality.photos_back_psnr_db = psnr_of(all.back);
    quality.unexplained_share = unexplained(all);
    quality.grade = grade_of(quality.expected_view_psnr_db);
    add_findings(quality);
    quality.by_direction = directions();
    return quality;
  }

 private:
  static Grade grade_of(double value, const Bounds& bounds) {
    if (value > bounds.again) return Grade::sweep_again;
    return value > bounds.fair ? Grade::fair : Grade::good;
  }

  Grade grade_of(double expected_db) const {
    return grade_of(-expected_db, {-options_.expected_db.fair, -options_.expected_db.again});
  }

  void find() {
    find_by_photo();
    find_by_motion();
    merge_repeated();
  }

  // The gravest first.
  void add_findings(SweepQuality& quality) {
    std::stable_sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) {
      return a.grade != b.grade ? a.grade > b.grade : a.weight > b.weight;
    });
    for (const Found& found : found_) {
      quality.grade = std::max(quality.grade, found.grade);
      quality.reasons.push_back(found.finding);
    }
  }

  static double unexplained(const DirectionEvidence& part) {
    return part.compared > 0 ? static_cast<double>(part.unexplained) / static_cast<double>(part.compared) : 0;
  }

  // Of the photos from the first one on, up to the last one.
  void add(QualityReason reason, double value, const Bounds& bounds, size_t first, size_t last) {
    const Grade grade = grade_of(value, bounds);
    if (grade == Grade::good) return;
    found_.push_back({over(reason, first, last), grade, (value - bounds.fair) / (bounds.again - bounds.fair)});
  }
  void add(QualityReason reason, double value, const Bounds& bounds) {
    add(reason, value, bounds, 0, evidence_.photos.size());
  }

  bool is_full_turn() const {
    return evidence_.first_deg == 0 && evidence_.photos.front().directions.size() == kFullTurn;
  }

  // Photographs of several rows go round more than once, directions of a full turn do not.
  QualityFinding on_the_turn(QualityFinding finding) const {
    if (!is_full_turn()) return finding;
    if (finding.to_deg - finding.from_deg >= kTurn_deg) return {finding.reason, 0, kTurn_deg};
    const double turns_deg = kTurn_deg * std::floor(finding.from_deg / kTurn_deg);
    return {finding.reason, finding.from_deg - turns_deg, finding.to_deg - turns_deg};
  }

  bool lies_in(const QualityFinding& finding, const DirectionQuality& direction) const {
    const auto overlaps = [&](double turned_deg) {
      return finding.from_deg - turned_deg < direction.to_deg && finding.to_deg - turned_deg > direction.from_deg;
    };
    return overlaps(0) || (is_full_turn() && overlaps(kTurn_deg));
  }

  double from(size_t photo) const {
    const double here = evidence_.photos[photo].heading_deg;
    return photo == 0 ? here : 0.5 * (here + evidence_.photos[photo - 1].heading_deg);
  }
  double to(size_t photo) const {
    const double here = evidence_.photos[photo].heading_deg;
    return photo + 1 == evidence_.photos.size() ? here : 0.5 * (here + evidence_.photos[photo + 1].heading_deg);
  }

  // Where the photos from the first one on, up to the last one, look: who sweeps to and fro is not farthest at either.
  QualityFinding over(QualityReason reason, size_t first, size_t last) const {
    QualityFinding finding{reason, from(first), from(first)};
    for (size_t i = first; i < last; ++i) {
      finding.from_deg = std::min({finding.from_deg, from(i), to(i)});
      finding.to_deg = std::max({finding.to_deg, from(i), to(i)});
    }
    return on_the_turn(finding);
  }

  // One reason is told once where both a measure and a doubt give it for the whole sweep.
  void merge_repeated() {
    std::stable_sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) { return a.grade > b.grade; });
    const auto covers = [](const Found& a, const Found& b) {
      return a.finding.reason == b.finding.reason && a.finding.from_deg <= b.finding.from_deg &&
             a.finding.to_deg >= b.finding.to_deg;
    };
    for (size_t i = 0; i < found_.size(); ++i)
      for (size_t j = found_.size() - 1; j > i; --j)
        if (covers(found_[i], found_[j])) found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(j));
  }

  // One finding for each run of photographs beyond the bound, one for all where they are most of them.
  void find_runs(QualityReason reason, const Bounds& bounds, const std::function<double(size_t)>& value) {
    const size_t count = evidence_.photos.size();
    std::vector<double> values;
    for (size_t i = 0; i < count; ++i) values.push_back(value(i));
    const auto beyond = [&](size_t i) { return grade_of(values[i], bounds) != Grade::good; };
    size_t many = 0;
    for (size_t i = 0; i < count; ++i) many += beyond(i) ? 1U : 0U;
    if (many == 0) return;
    if (2 * many > count) {
      std::vector<double> sorted = values;
      std::sort(sorted.begin(), sorted.end());
      add(reason, std::max(sorted[count / 2], sorted[count - many]), bounds);
      return;
    }
    for (size_t i = 0; i < count;) {
      if (!beyond(i)) {
        ++i;
        continue;
      }
      size_t end = i;
      double most = values[i];
      while (end < count && beyond(end)) most = std::max(most, values[end++]);
      add(reason, most, bounds, i, end);
      i = end;
    }
  }

  void find_by_photo() {
    const auto& photos = evidence_.photos;
    const DirectionEvidence all = everything();
    find_runs(QualityReason::blurred, options_.smear, [&](size_t i) { return smear_of(photos[i].measures); });
    add(QualityReason::little_overlap, usual_shift(), options_.usual_shift);
    find_runs(QualityReason::little_overlap, options_.shift, [&](size_t i) { return photos[i].shift; });
    find_runs(QualityReason::exposure_jumps, options_.exposure, [&](size_t i) { return exposure_jump(evidence_, i); });
    if (grade_of(unexplained(all), options_.unexplained) != Grade::good)
      find_runs(QualityReason::contradicted, options_.unexplained, [&](size_t i) { return unexplained(photos[i]); });
    add(QualityReason::dark, dark_noise(), options_.dark_noise);
    const double holes = static_cast<double>(all.holes) / static_cast<double>(std::max<int64_t>(1, all.pixels));
    add(QualityReason::holes, holes, options_.holes);
  }

  void find_by_motion() {
    const MotionMeasures motion = motion_of(evidence_);
    const bool turned = motion.parallax > 0 && motion.parallax < options_.least_parallax;
    if (evidence_.motion == SweepMotion::rotation || turned) add_fair(QualityReason::no_parallax);
    if (grade_of(motion.outward, options_.outward) != Grade::good)
      add(QualityReason::moved_forward, motion.outward, options_.outward);
    else if (evidence_.motion == SweepMotion::straight)
      add_fair(evidence_.inward > options_.inward ? QualityReason::looked_inward : QualityReason::moved_straight);
    find_by_poses(motion);
  }

  void find_by_poses(const MotionMeasures& motion) {
    if (evidence_.doubt == DoubtfulPoses::contradicted) {
      const bool is_torn = grade_of(unexplained(everything()), options_.unexplained) != Grade::good;
      if (is_torn)
        add_again(QualityReason::poses_doubtful);
      else
        add_fair(QualityReason::poses_doubtful);
    }
    if (evidence_.doubt == DoubtfulPoses::loose) add_fair(QualityReason::little_overlap);
    if (evidence_.doubt == DoubtfulPoses::lens) add_fair(QualityReason::lens_doubtful);
    if (evidence_.motion == SweepMotion::arc) add(QualityReason::poses_doubtful, motion.mismatch, options_.mismatch);
    add(QualityReason::contradicted, 1 - evidence_.agreement, options_.disagreement);
    add(QualityReason::lens_doubtful, evidence_.reprojection, options_.reprojection);
    const auto posed = static_cast<double>(evidence_.photos.size());
    add(QualityReason::photos_left_out, 1 - posed / std::max(posed, static_cast<double>(evidence_.photos_taken)),
        options_.left_out);
  }

  void add_fair(QualityReason reason) { add(reason, 1, {0, 2}); }
  void add_again(QualityReason reason) { add(reason, 2, {0, 1}); }

  // Noise that a well exposed photograph would show. One camera's is about the same all along the sweep, and texture
  // adds to what is measured: the quarter of the photographs that show least tell it.
  double dark_noise() const {
    std::vector<double> noise;
    for (const PhotoEvidence& photo : evidence_.photos)
      noise.push_back((photo.measures.noise + kRounding) * kNoiseGrey / std::max(1.0, photo.measures.brightness));
    return ranked(noise, noise.size() / 4);
  }

  // Of the photographs but the first, which has none before it.
  double usual_shift() const {
    std::vector<double> shifts;
    for (size_t i = 1; i < evidence_.photos.size(); ++i) shifts.push_back(evidence_.photos[i].shift);
    return shifts.empty() ? 0 : ranked(shifts, shifts.size() / 2);
  }

  static double unexplained(const PhotoEvidence& photo) {
    DirectionEvidence all;
    for (const DirectionEvidence& part : photo.directions) all.add(part);
    return unexplained(all);
  }

  DirectionEvidence everything() const {
    DirectionEvidence all;
    for (const PhotoEvidence& photo : evidence_.photos)
      for (const DirectionEvidence& part : photo.directions) all.add(part);
    return all;
  }

  std::vector<DirectionQuality> directions() const {
    std::vector<DirectionQuality> all;
    const size_t count = evidence_.photos.front().directions.size();
    for (size_t d = 0; d < count; ++d) {
      DirectionEvidence part;
      for (const PhotoEvidence& photo : evidence_.photos) part.add(photo.directions[d]);
      int64_t pixels = 0;
      for (const DirectionEvidence& other : evidence_.photos.front().directions) pixels += other.pixels;
      if (static_cast<double>(part.pixels) < kLeastSeen * static_cast<double>(pixels)) continue;
      DirectionQuality quality;
      quality.from_deg = evidence_.first_deg + static_cast<double>(d) * kDirection_deg;
      quality.to_deg = quality.from_deg + kDirection_deg;
      quality.expected_view_psnr_db = expected_view_psnr(features_of(evidence_, d));
      quality.photos_back_psnr_db = psnr_of(part.back);
      quality.unexplained_share = unexplained(part);
      quality.grade = grade_of(quality.expected_view_psnr_db);
      for (const Found& found : found_)
        if (lies_in(found.finding, quality)) quality.grade = std::max(quality.grade, found.grade);
      all.push_back(quality);
    }
    return all;
  }

  const SweepEvidence& evidence_;
  const JudgeOptions& options_;
  std::vector<Found> found_;
};

}  // namespace

SweepQuality judge(const SweepEvidence& evidence, const JudgeOptions& options) {
  if (evidence.photos.empty()) return {};
  return Judge(evidence, options).judge();
}

SweepQuality judge_sweep(const SweepEvidence& evidence, const JudgeOptions& options) {
  if (evidence.photos.empty()) return {};
  return Judge(evidence, options).judge_sweep();
}

}  // namespace ldp
