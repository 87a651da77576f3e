// Expected against true quality of new views, over good and spoiled sweeps of synthetic scenes.
//
//   verdict_bench [--seeds FIRST-LAST] [--spoils all|clean,blur,...] [--threads N]   builds and judges sweeps
//   verdict_bench --again FILE...                                   judges sweeps of such lines again, without building
//   verdict_bench --capture FOLDER [--pixels N]                     judges photographs without truth
//
// Prints a line of JSON a sweep, and the summary (summary.h) to standard error. True quality: twelve views, as many as
// a perfect camera would take from beside the path, exposure matched, placed in the panorama's world by the cameras
// that it found.
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/captures/folder_frames.h"
#include "core/view/image_quality.h"
#include "core/view/render.h"
#include "tests/bench/verdict/judged_sweep.h"
#include "tests/bench/verdict/spoiled_sweeps.h"
#include "tests/bench/verdict/summary.h"

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

TrueQuality true_quality(const SyntheticSweep& sweep, const LayeredPanorama& panorama) {
  const Similarity place = found_from_true(sweep.cameras, panorama.cameras);
  const Renderer renderer(panorama);
  TrueQuality mean;
  for (const TrueView& view : sweep.views) {
    Camera camera = view.camera;
    camera.pose = place(camera.pose);
    const View shown = renderer.render(camera, {});
    const ViewQuality q = view_quality(shown.colour, shown.alpha, view.picture);
    const double share = 1.0 / static_cast<double>(sweep.views.size());
    mean.psnr_db += share * q.psnr_db, mean.matched_db += share * q.psnr_matched_db;
    mean.holes += share * q.holes, mean.ssim += share * q.ssim;
  }
  return mean;
}

JudgedSweep judge_built(const FrameSource& frames, const BuildOptions& options, const SyntheticSweep* sweep,
                        const Job& job) {
  JudgedSweep judged;
  try {
    const BuildResult result = build(frames, options, job);
    if (sweep != nullptr) judged.truth = true_quality(*sweep, result.panorama);
    judged.notes = result.report.notes;
    judged.evidence = result.report.evidence;
    judged.quality = result.report.quality;
  } catch (const Impossible& error) {
    judged.refused = error.what();
  }
  return judged;
}

JudgedSweep judge_synthetic(uint32_t seed, Spoil spoil, const Job& job) {
  const SyntheticSweep sweep = make_sweep(seed, spoil, job);
  JudgedSweep judged = judge_built(sweep.frames, sweep.options, &sweep, job);
  judged.scene = sweep.scene, judged.seed = seed, judged.spoil = name_of(spoil);
  return judged;
}

JudgedSweep judge_capture(const std::string& folder, int64_t pixels, const Job& job) {
  const FolderFrames frames(folder, {.max_pixels = pixels});
  JudgedSweep judged = judge_built(frames, {}, nullptr, job);
  judged.scene = folder, judged.spoil = "capture";
  return judged;
}

void print(const JudgedSweep& sweep) {
  std::printf("%s\n", json_of(sweep).dump().c_str());
  std::fflush(stdout);
}

std::vector<JudgedSweep> read_again(const std::vector<std::string>& files) {
  std::vector<JudgedSweep> sweeps;
  for (const std::string& file : files) {
    std::ifstream in(file);
    if (!in) std::fprintf(stderr, "cannot read %s\n", file.c_str());
    for (std::string text; std::getline(in, text);) sweeps.push_back(judged_again(Json::parse(text)));
  }
  return sweeps;
}

struct Arguments {
  uint32_t first = 1, last = 4;
  std::string spoils = "all", capture;
  int64_t pixels = 2'100'000;
  int threads = 2;
  std::vector<std::string> again;
};

constexpr char kUsage[] =
    "usage: verdict_bench [--seeds FIRST-LAST] [--spoils all|clean,blur,...] [--threads N] | --again FILE... | "
    "--capture FOLDER [--pixels N]";

Arguments arguments_from(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (i + 1 == argc) throw std::runtime_error(kUsage);
    const char* value = argv[i + 1];
    if (name == "--again") {
      arguments.again.assign(argv + i + 1, argv + argc);
      break;
    }
    if (name == "--seeds" && std::sscanf(value, "%u-%u", &arguments.first, &arguments.last) == 2) continue;
    if (name == "--spoils")
      arguments.spoils = value;
    else if (name == "--capture")
      arguments.capture = value;
    else if (name == "--pixels")
      arguments.pixels = std::atoll(value);
    else if (name == "--threads")
      arguments.threads = std::atoi(value);
    else
      throw std::runtime_error(kUsage);
  }
  return arguments;
}

std::vector<JudgedSweep> judge_all(const Arguments& arguments, const Job& job) {
  std::vector<JudgedSweep> sweeps;
  for (uint32_t seed = arguments.first; seed <= arguments.last; ++seed) {
    for (const Spoil spoil : kSpoils) {
      const bool wanted =
          ("," + arguments.spoils + ",").find(std::string(",") + name_of(spoil) + ",") != std::string::npos;
      if (arguments.spoils != "all" && !wanted) continue;
      sweeps.push_back(judge_synthetic(seed, spoil, job));
      print(sweeps.back());
    }
  }
  return sweeps;
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments arguments = arguments_from(argc, argv);
  Job job;
  job.threads = arguments.threads;
  if (!arguments.capture.empty()) {
    print(judge_capture(arguments.capture, arguments.pixels, job));
    return 0;
  }
  const std::vector<JudgedSweep> sweeps =
      arguments.again.empty() ? judge_all(arguments, job) : read_again(arguments.again);
  std::fputs(summary_of(sweeps).c_str(), stderr);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
