#include "core/poses/tracks/geometric_verification.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace ldp {
namespace {

constexpr int kGlance = 300;           // strongest features that a quick look compares
constexpr size_t kGlanceMatches = 12;  // and how many must match for a closer look

std::vector<Match> agreeing(const Features& a, const Features& b, const std::vector<Match>& matches, size_t least,
                            const PairOptions& options) {
  if (matches.size() < least) return {};
  std::vector<cv::Point2d> in_a, in_b;
  for (const Match& m : matches) {
    const Eigen::Vector2d &p = a.positions[static_cast<size_t>(m.a)], &q = b.positions[static_cast<size_t>(m.b)];
    in_a.emplace_back(p.x(), p.y());
    in_b.emplace_back(q.x(), q.y());
  }
  cv::UsacParams usac;
  usac.confidence = 0.9999;
  usac.isParallel = false;
  usac.maxIterations = 2000;
  usac.randomGeneratorState = static_cast<int>(options.seed);
  usac.threshold = options.tolerance * std::max(a.width, a.height);
  std::vector<uchar> mask;
  const cv::Mat f = cv::findFundamentalMat(in_a, in_b, mask, usac);
  std::vector<Match> kept;
  for (size_t i = 0; !f.empty() && i < mask.size() && i < matches.size(); ++i) {
    if (mask[i]) kept.push_back(matches[i]);
  }
  const double share = static_cast<double>(kept.size()) / static_cast<double>(matches.size());
  return kept.size() < least || share < options.least_share ? std::vector<Match>{} : kept;
}

}  // namespace

std::vector<Match> match_pair(const Features& a, const Features& b, bool neighbours, const PairOptions& options) {
  if (!neighbours) {
    MatchOptions glance;
    glance.most = kGlance;
    if (match_features(a, b, glance).size() < kGlanceMatches) return {};
  }
  const int least = neighbours ? options.least_inliers : options.least_loop_inliers;
  return agreeing(a, b, match_features(a, b, MatchOptions{}), static_cast<size_t>(least), options);
}

}  // namespace ldp
