#include "core/photos/exposure_compensation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/base/exact_math.h"
#include "core/photos/exposure/normal_equations.h"
#include "core/photos/exposure_tuning.h"

namespace ldp {

using namespace exposure;

namespace {

struct Link {
  int a = 0, b = 0;
  double log_ratio = 0;  // what log gain a - log gain b should be
  double sigma = 0;
};

// What is known of two photos' gains: their common factor, then each channel's over that. Tints differ much less than
// exposures, and what misplaces samples tells little of them.
constexpr size_t kFactors = 4;

// Log ratios b / a of what two photos see, per factor.
std::array<std::vector<double>, kFactors> log_ratios(const Overlap& overlap) {
  std::array<std::vector<double>, kFactors> ratios;
  for (const PairedColours& pair : overlap.colours) {
    std::array<double, 3> ratio{};
    for (size_t c = 0; c < 3; ++c) ratio[c] = exact_log(pair.b[c]) - exact_log(pair.a[c]);
    const double common = (ratio[0] + ratio[1] + ratio[2]) / 3;
    ratios[0].push_back(common);
    for (size_t c = 0; c < 3; ++c) ratios[c + 1].push_back(ratio[c] - common);
  }
  return ratios;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Link link_of(std::vector<double>& ratios, int a, int b) {
  Link link{a, b, median(ratios), 0};
  for (double& ratio : ratios) ratio = std::abs(ratio - link.log_ratio);
  const double deviation = median(ratios);
  link.sigma = std::max(kLeastLinkSigma, 3 * deviation / std::sqrt(static_cast<double>(ratios.size())));
  return link;
}

using Links = std::array<std::vector<Link>, kFactors>;

Links links_of(const std::vector<Overlap>& overlapping) {
  Links links;
  for (const Overlap& overlap : overlapping) {
    auto ratios = log_ratios(overlap);
    for (size_t f = 0; f < kFactors; ++f) links[f].push_back(link_of(ratios[f], overlap.a, overlap.b));
  }
  return links;
}

void add_difference(const Link& link, double difference, double weight, NormalEquations& equations) {
  const std::array<Term, 2> terms{{{static_cast<size_t>(link.a), 1}, {static_cast<size_t>(link.b), -1}}};
  equations.add(terms, difference, weight);
}

// Log factors that fit the links best; links that contradict the others lose weight.
std::vector<double> solve_links(const std::vector<Link>& links, double prior_sigma, size_t n) {
  std::vector<double> x(n, 0), weight(links.size());
  for (int round = 0; round < kReweightings; ++round) {
    for (size_t i = 0; i < links.size(); ++i) {
      const Link& link = links[i];
      const double error = x[static_cast<size_t>(link.a)] - x[static_cast<size_t>(link.b)] - link.log_ratio;
      const double spread = error / (3 * link.sigma);
      weight[i] = (round == 0 ? 1 : 1 / (1 + spread * spread)) / (link.sigma * link.sigma);
    }
    const double prior = 1 / (prior_sigma * prior_sigma);
    NormalEquations equations(n, kAnchor);
    for (size_t i = 0; i < links.size(); ++i) {
      add_difference(links[i], links[i].log_ratio, weight[i], equations);
      add_difference(links[i], 0, prior, equations);
    }
    x = equations.solution();
  }
  double mean = 0;
  for (const double value : x) mean += value / static_cast<double>(n);
  for (double& value : x) value -= mean;
  return x;
}

}  // namespace

std::vector<Gain> exposure_gains(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails,
                                 const std::vector<ScenePoint>& points) {
  const size_t n = cameras.size();
  const Links links = links_of(overlaps(cameras, thumbnails, points));
  std::vector<Gain> gains(n);
  const auto exposure = solve_links(links[0], kExposureSigma, n);
  for (size_t c = 0; c < 3; ++c) {
    const auto tint = solve_links(links[c + 1], kTintSigma, n);
    for (size_t i = 0; i < n; ++i) {
      const double gain = std::clamp(exact_exp(exposure[i] + tint[i]), 1 / kLargestGain, kLargestGain);
      gains[i][c] = static_cast<float>(std::floor(gain * 1024 + 0.5) / 1024);
    }
  }
  return gains;
}

}  // namespace ldp
