// Expected against true quality of new views, over good and spoiled sweeps of synthetic scenes.
//
//   verdict_bench [--seeds FIRST-LAST] [--spoils all|clean,blur,...] [--threads N]
//
// Prints one line of JSON a sweep. True quality: twelve views, as many as a perfect camera would take from beside the
// path, exposure matched, placed in the panorama's world by the cameras that it found.
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "core/captures/folder_frames.h"
#include "core/verdict/expectation.h"
#include "core/verdict/words.h"
#include "core/view/image_quality.h"
#include "core/view/render.h"
#include "tests/bench/spoiled_sweeps.h"

namespace {

using namespace ldp;
using Json = nlohmann::ordered_json;

struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = Eigen::Vector3d::Zero();
  Pose operator()(const Pose& pose) const {
    return {rotation * pose.world_from_camera, to_mean + scale * (rotation * (pose.centre - from_mean))};
  }
};

// What brings true cameras onto those found: the mean of their turns, then scale and place of their centres.
Similarity found_from_true(const std::vector<Camera>& truth, const std::vector<Camera>& found) {
  std::vector<std::pair<Pose, Pose>> pairs;
  for (const Camera& t : truth)
    for (const Camera& f : found)
      if (t.name == f.name) pairs.emplace_back(t.pose, f.pose);
  Similarity s;
  if (pairs.empty()) return s;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& [t, f] : pairs) {
    sum += f.world_from_camera * t.world_from_camera.transpose();
    s.from_mean += t.centre / static_cast<double>(pairs.size());
    s.to_mean += f.centre / static_cast<double>(pairs.size());
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  s.rotation = svd.matrixU() * flip * svd.matrixV().transpose();
  double cross = 0, own = 0;
  for (const auto& [t, f] : pairs) {
    const Eigen::Vector3d from = s.rotation * (t.centre - s.from_mean);
    cross += from.dot(f.centre - s.to_mean);
    own += from.squaredNorm();
  }
  if (own > 1e-6 && cross > 0) s.scale = cross / own;
  return s;
}

Json truth_json(const SyntheticSweep& sweep, const LayeredPanorama& panorama, const Renderer& renderer) {
  const Similarity place = found_from_true(sweep.cameras, panorama.cameras);
  double psnr = 0, matched = 0, holes = 0, ssim = 0;
  for (const TrueView& view : sweep.views) {
    Camera camera = view.camera;
    camera.pose = place(camera.pose);
    const View shown = renderer.render(camera, {});
    const ViewQuality q = view_quality(shown.colour, shown.alpha, view.picture);
    const double share = 1.0 / static_cast<double>(sweep.views.size());
    psnr += share * q.psnr_db, matched += share * q.psnr_matched_db, holes += share * q.holes, ssim += share * q.ssim;
  }
  return {{"psnr", psnr}, {"matched", matched}, {"holes", holes}, {"ssim", ssim}};
}

Json features_json(const SweepEvidence& evidence) {
  Json json = Json::array();
  for (const double feature : features_of(evidence)) json.push_back(feature);
  return json;
}

Json quality_json(const BuildReport& report) {
  Json reasons = Json::array();
  for (const QualityFinding& finding : report.quality.reasons)
    reasons.push_back(std::string(code_of(finding.reason)) + " " + std::to_string(std::lround(finding.from_deg)) + " " +
                      std::to_string(std::lround(finding.to_deg)));
  const MotionMeasures motion = motion_of(report.evidence);
  return {{"verdict", name_of(report.quality.grade)},
          {"expected", report.quality.expected_view_psnr_db},
          {"back", report.quality.photos_back_psnr_db},
          {"unexplained", report.quality.unexplained_share},
          {"reasons", reasons},
          {"parallax", motion.parallax},
          {"features", features_json(report.evidence)}};
}

Json judge(const SyntheticSweep& sweep, const Job& job) {
  Json json{{"scene", sweep.scene}, {"seed", sweep.seed}, {"spoil", name_of(sweep.spoil)}};
  try {
    const BuildResult result = build(sweep.frames, sweep.options, job);
    const Renderer renderer(result.panorama);
    json["truth"] = truth_json(sweep, result.panorama, renderer);
    json["notes"] = result.report.notes;
    json["quality"] = quality_json(result.report);
  } catch (const Impossible& error) {
    json["refused"] = error.what();
  }
  return json;
}

Json judge_capture(const std::string& folder, int64_t pixels, const Job& job) {
  const FolderFrames frames(folder, {.max_pixels = pixels});
  const BuildResult result = build(frames, {}, job);
  return {{"scene", folder},
          {"seed", 0},
          {"spoil", "capture"},
          {"notes", result.report.notes},
          {"quality", quality_json(result.report)}};
}

}  // namespace

int main(int argc, char** argv) {
  uint32_t first = 1, last = 4;
  std::string spoils = "all", capture;
  int64_t pixels = 2'100'000;
  Job job;
  job.threads = 2;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--seeds") == 0) std::sscanf(argv[i + 1], "%u-%u", &first, &last);
    if (std::strcmp(argv[i], "--spoils") == 0) spoils = argv[i + 1];
    if (std::strcmp(argv[i], "--capture") == 0) capture = argv[i + 1];
    if (std::strcmp(argv[i], "--pixels") == 0) pixels = std::atoll(argv[i + 1]);
    if (std::strcmp(argv[i], "--threads") == 0) job.threads = std::atoi(argv[i + 1]);
  }
  if (!capture.empty()) {
    std::printf("%s\n", judge_capture(capture, pixels, job).dump().c_str());
    return 0;
  }
  for (uint32_t seed = first; seed <= last; ++seed) {
    for (const Spoil spoil : kSpoils) {
      if (spoils != "all" && ("," + spoils + ",").find(std::string(",") + name_of(spoil) + ",") == std::string::npos)
        continue;
      std::printf("%s\n", judge(make_sweep(seed, spoil, job), job).dump().c_str());
      std::fflush(stdout);
    }
  }
}
