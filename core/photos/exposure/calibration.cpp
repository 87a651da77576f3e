#include "core/photos/exposure/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/exact_math.h"
#include "core/photos/exposure/normal_equations.h"
#include "core/photos/exposure_tuning.h"

namespace ldp {

using namespace exposure;

namespace {

using Slopes = std::array<double, kSlopes>;

// Shares of the slopes at a level; beyond the first and last one they stay the same.
Slopes shares_at(double level) {
  Slopes shares{};
  const double at = std::clamp((level - kFirstSlope) / kSlopeStep, 0.0, static_cast<double>(kSlopes - 1));
  const size_t first = std::min(static_cast<size_t>(at), kSlopes - 2);
  shares[first + 1] = at - static_cast<double>(first);
  shares[first] = 1 - shares[first + 1];
  return shares;
}

double dot(const Slopes& a, const Slopes& b) {
  double sum = 0;
  for (size_t k = 0; k < kSlopes; ++k) sum += a[k] * b[k];
  return sum;
}

// One channel of one thing in two photographs.
struct Sample {
  double log_ratio = 0;  // of the second one's level to the first one's
  Slopes shares{};       // of the slopes in the mean one between them
};

double square(double x) { return x * x; }

class Calibrator {
 public:
  Calibrator(const std::vector<Overlap>& overlapping, size_t photos)
      : overlapping_(overlapping), photos_(photos), log_exposures_(3 * photos, 0) {
    slopes_.fill(kMeanSlope);
  }

  Calibration run() {
    for (int round = 0; round < kCalibrations; ++round) {
      log_exposures_ = solved_exposures(round > 0);
      slopes_ = solved_slopes();
      normalise();
    }
    return {response(), light_gains()};
  }

 private:
  static size_t unknown(int photo, size_t channel) { return 3 * static_cast<size_t>(photo) + channel; }

  double log_exposures_apart(const Overlap& overlap, size_t c) const {
    return log_exposures_[unknown(overlap.b, c)] - log_exposures_[unknown(overlap.a, c)];
  }

  // The mean over the light between the two levels: a slope counts by how much light it stands for.
  Sample sample(const PairedColours& pair, size_t c) const {
    Sample sample;
    const double log_a = exact_log(pair.a[c]);
    sample.log_ratio = exact_log(pair.b[c]) - log_a;
    double sum = 0;
    for (const double share : {1 / 6.0, 0.5, 5 / 6.0}) {
      const Slopes at = shares_at(exact_exp(log_a + share * sample.log_ratio));
      const double light = 1 / dot(at, slopes_);
      sum += light;
      for (size_t k = 0; k < kSlopes; ++k) sample.shares[k] += light * at[k];
    }
    for (double& share : sample.shares) share /= sum;
    return sample;
  }

  static double weight(double residual) { return 1 / (square(kLevelSigma) + square(residual)); }

  template <typename Visit>
  void for_each_sample(const Visit& visit) const {
    for (const Overlap& overlap : overlapping_)
      for (const PairedColours& pair : overlap.colours)
        for (size_t c = 0; c < 3; ++c) visit(overlap, c, sample(pair, c));
  }

  std::vector<double> solved_exposures(bool reweighted) const {
    NormalEquations equations(log_exposures_.size(), kAnchor);
    for (const Overlap& overlap : overlapping_)
      for (const size_t c : {size_t{0}, size_t{2}}) {
        const std::array<Term, 4> tint{{{unknown(overlap.a, c), 1},
                                        {unknown(overlap.a, 1), -1},
                                        {unknown(overlap.b, c), -1},
                                        {unknown(overlap.b, 1), 1}}};
        equations.add(tint, 0, 1 / square(kLightTintSigma));
      }
    for_each_sample([&](const Overlap& overlap, size_t c, const Sample& s) {
      const double slope = dot(s.shares, slopes_);
      const double residual = reweighted ? s.log_ratio - slope * log_exposures_apart(overlap, c) : 0;
      const std::array<Term, 2> apart{{{unknown(overlap.a, c), -slope}, {unknown(overlap.b, c), slope}}};
      equations.add(apart, s.log_ratio, weight(residual));
    });
    return equations.solution();
  }

  Slopes solved_slopes() const {
    NormalEquations equations(kSlopes, kAnchor);
    for (size_t k = 0; k + 2 < kSlopes; ++k) {
      const std::array<Term, 3> bend{{{k, 1}, {k + 1, -2}, {k + 2, 1}}};
      equations.add(bend, 0, 1 / square(kSlopeBend));
    }
    for_each_sample([&](const Overlap& overlap, size_t c, const Sample& s) {
      const double apart = log_exposures_apart(overlap, c);
      std::array<Term, kSlopes> terms{};
      for (size_t k = 0; k < kSlopes; ++k) terms[k] = {k, s.shares[k] * apart};
      equations.add(terms, s.log_ratio, weight(s.log_ratio - dot(s.shares, slopes_) * apart));
    });
    const std::vector<double> solution = equations.solution();
    Slopes slopes{};
    for (size_t k = 0; k < kSlopes; ++k) slopes[k] = std::max(kLeastSlope, solution[k]);
    return slopes;
  }

  // Photographs tell light to a power only.
  void normalise() {
    double mean = 0;
    for (const double slope : slopes_) mean += slope / kSlopes;
    for (double& slope : slopes_) slope *= kMeanSlope / mean;
    for (double& exposure : log_exposures_) exposure *= mean / kMeanSlope;
  }

  ResponseCurve response() const {
    constexpr size_t kLast = ResponseCurve::kLevelsPerKnot * (ResponseCurve::kKnots - 1);
    std::array<double, kLast + 1> log_light{};
    const auto step = [&](double level) { return 1 / (level * dot(shares_at(level), slopes_)); };
    for (size_t v = 2; v <= kLast; ++v) {
      const auto level = static_cast<double>(v);
      log_light[v] = log_light[v - 1] + (step(level - 1) + step(level)) / 2;
    }
    ResponseCurve curve;
    constexpr double kFull = 1 << 30;
    for (size_t i = 1; i < ResponseCurve::kKnots; ++i)
      curve.light[i] = static_cast<uint32_t>(
          std::floor(kFull * exact_exp(log_light[i * ResponseCurve::kLevelsPerKnot] - log_light[kLast]) + 0.5));
    return curve;
  }

  std::vector<Gain> light_gains() const {
    std::vector<Gain> gains(photos_);
    for (size_t c = 0; c < 3; ++c) {
      double mean = 0;
      for (size_t i = 0; i < photos_; ++i) mean += log_exposures_[3 * i + c] / static_cast<double>(photos_);
      for (size_t i = 0; i < photos_; ++i) {
        const double gain = exact_exp(mean - log_exposures_[3 * i + c]);
        gains[i][c] = static_cast<float>(
            std::floor(std::clamp(gain, 1 / kLargestLightGain, kLargestLightGain) * 4096 + 0.5) / 4096);
      }
    }
    return gains;
  }

  const std::vector<Overlap>& overlapping_;
  size_t photos_;
  std::vector<double> log_exposures_;  // R, G and B of each photograph
  Slopes slopes_{};                    // of level over light, logarithms both
};

}  // namespace

Calibration calibrate(const std::vector<Overlap>& overlapping, size_t photos) {
  return Calibrator(overlapping, photos).run();
}

}  // namespace ldp
