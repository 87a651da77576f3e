#include "core/poses/tracks/geometric_verification.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {
namespace {

std::vector<Match> epipolar_inliers(const Features& a, const Features& b, const std::vector<Match>& matches,
                                    size_t min_inliers, const TwoViewOptions& options) {
  if (matches.size() < min_inliers) return {};
  std::vector<cv::Point2d> in_a, in_b;
  for (const Match& m : matches) {
    const Eigen::Vector2d &p = a.positions[static_cast<size_t>(m.a)], &q = b.positions[static_cast<size_t>(m.b)];
    in_a.emplace_back(p.x(), p.y());
    in_b.emplace_back(q.x(), q.y());
  }
  cv::UsacParams usac;
  usac.confidence = kRansacConfidence;
  usac.isParallel = false;
  usac.maxIterations = kMaxRansacIterations;
  usac.randomGeneratorState = static_cast<int>(options.seed);
  usac.threshold = options.max_epipolar_error * std::max(a.width, a.height);
  std::vector<uchar> mask;
  const cv::Mat f = cv::findFundamentalMat(in_a, in_b, mask, usac);
  std::vector<Match> kept;
  for (size_t i = 0; !f.empty() && i < mask.size() && i < matches.size(); ++i) {
    if (mask[i]) kept.push_back(matches[i]);
  }
  const double share = static_cast<double>(kept.size()) / static_cast<double>(matches.size());
  return kept.size() < min_inliers || share < options.min_inlier_ratio ? std::vector<Match>{} : kept;
}

}  // namespace

std::vector<Match> match_and_verify(const Features& a, const Features& b, bool neighbours,
                                    const TwoViewOptions& options) {
  if (!neighbours) {
    MatchOptions preview;
    preview.max_features = kPreviewFeatures;
    if (match_features(a, b, preview).size() < kMinPreviewMatches) return {};
  }
  const int min_inliers = neighbours ? options.min_inliers : options.min_loop_closure_inliers;
  return epipolar_inliers(a, b, match_features(a, b, MatchOptions{}), static_cast<size_t>(min_inliers), options);
}

}  // namespace ldp::sfm
