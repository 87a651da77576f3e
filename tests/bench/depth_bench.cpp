// How true the depths of the sweep are: error of the best label by cost alone, of the label map after the cut, and of
// the refined disparity, against a rendered capture's depth maps.
//
//   depth_bench CAPTURE [--central] [--pictures DIR] [--truth FILE]
//
// FILE keeps the truth from run to run: it takes minutes to find. CAPTURE holds frames/, transforms.json and
// frames_depth/ (as sim/scene_capture.h writes them). Errors are in labels of 16.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/arc/arc.h"
#include "core/base/files.h"
#include "core/captures/transforms.h"
#include "core/photos/images.h"
#include "core/poses/poses.h"
#include "core/rectify/rectify.h"
#include "core/sweep/cost_volume.h"
#include "tests/bench/captures.h"
#include "tests/bench/depth_truth.h"
#ifdef HAVE_SOLVE
#include "core/solve/solve.h"
#endif

namespace ldp {
namespace {

namespace fs = std::filesystem;

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void report(const char* what, const DisparityMap& found, const DisparityMap& truth) {
  std::vector<int> errors;
  for (size_t i = 0; i < truth.samples.size(); ++i) {
    if (truth.samples[i] != kNoDisparity && found.samples[i] != kNoDisparity)
      errors.push_back(std::abs(truth.samples[i] - found.samples[i]));
  }
  const auto share = [&](int limit) {
    return 100.0 * static_cast<double>(std::count_if(errors.begin(), errors.end(), [&](int e) { return e <= limit; })) /
           static_cast<double>(errors.size());
  };
  double sum = 0;
  for (const int e : errors) sum += std::min(e, 255);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  std::printf(
      "%-10s median %.3f  truncated mean %.3f  within 1/8 %5.1f %%  1/4 %5.1f %%  1/2 %5.1f %%  1 %5.1f %%  2 %5.1f "
      "%%\n",
      what, errors[errors.size() / 2] / 255.0, sum / 255 / static_cast<double>(errors.size()), share(32), share(64),
      share(128), share(255), share(510));
}

DisparityMap of_labels(const Plane<uint8_t>& labels) {
  DisparityMap disparity(labels.width, labels.height);
  for (size_t i = 0; i < labels.samples.size(); ++i)
    disparity.samples[i] = static_cast<uint16_t>(labels.samples[i] * (kDisparitySteps / 15));
  return disparity;
}

Plane<uint8_t> cheapest_labels(const CostSource& source, Plane<uint8_t>& grey, Plane<uint8_t>& least) {
  const int labels = source.labels(), height = source.height();
  Plane<uint8_t> best(source.width(), height);
  grey = least = best;
  for (int x = 0; x < source.width(); x += 128) {
    const Window window{x, 0, std::min(128, source.width() - x), height};
    std::vector<uint8_t> cost(static_cast<size_t>(window.width * height * labels)), median(cost.size());
    source.read(window, cost.data(), median.data());
    for (int i = 0; i < window.width; ++i) {
      for (int y = 0; y < height; ++y) {
        const uint8_t* costs = cost.data() + (i * height + y) * labels;
        const auto l = std::min_element(costs, costs + labels) - costs;
        best.at(x + i, y) = static_cast<uint8_t>(l);
        least.at(x + i, y) = costs[l];
        grey.at(x + i, y) = median[static_cast<size_t>((i * height + y) * labels + l)];
      }
    }
  }
  return best;
}

void save(const std::string& folder, const char* name, const DisparityMap& disparity) {
  if (folder.empty()) return;
  Plane<uint8_t> grey(disparity.width, disparity.height);
  for (size_t i = 0; i < grey.samples.size(); ++i) {
    grey.samples[i] =
        disparity.samples[i] == kNoDisparity ? 0 : static_cast<uint8_t>(disparity.samples[i] * 255 / kDisparitySteps);
  }
  write_file(fs::path(folder) / name, encode_png(grey));
}

// The truth takes minutes, and is the same while poses and grid are.
template <typename Compute>
DisparityMap cached_truth(const std::string& file, const Compute& compute) {
  if (std::ifstream in(file, std::ios::binary); !file.empty() && in) {
    int32_t size[2];
    in.read(reinterpret_cast<char*>(size), sizeof size);
    DisparityMap truth(size[0], size[1]);
    in.read(reinterpret_cast<char*>(truth.samples.data()), static_cast<std::streamsize>(2 * truth.samples.size()));
    return truth;
  }
  const DisparityMap truth = compute();
  if (!file.empty()) {
    std::ofstream out(file, std::ios::binary);
    const int32_t size[2] = {truth.width, truth.height};
    out.write(reinterpret_cast<const char*>(size), sizeof size);
    out.write(reinterpret_cast<const char*>(truth.samples.data()),
              static_cast<std::streamsize>(2 * truth.samples.size()));
  }
  return truth;
}

int run(const fs::path& capture, Rays rays, const std::string& pictures, const std::string& kept_truth) {
  const Job job;
  const auto given = read_transforms(capture / "transforms.json");
  const CaptureFrames frames(capture / "frames", given);
  double start = seconds();
  const auto lap = [&](const char* what) {
    std::printf("%-10s %.2f s\n", what, seconds() - start);
    start = seconds();
  };
  const Poses poses = triangulate(frames, given, {}, job);
  lap("points");
  const ArcFit fit = fit_arc(poses.cameras);
  GridOptions grid_options;
  grid_options.rays = rays;
  const PanoramaGrid grid = lay_grid(fit.arc, poses.cameras, poses.points, grid_options);
  std::printf("grid %dx%d, depths %.2f to %.2f, radius %.3f\n", grid.width, grid.height, 1 / grid.w_near,
              1 / grid.w_far, fit.arc.radius);
  std::vector<Plane<float>> depths;
  for (const Camera& camera : poses.cameras) {
    depths.push_back(read_npy(capture / "frames_depth" / fs::path(camera.name).replace_extension(".npy")));
  }
  start = seconds();
  const DisparityMap truth = cached_truth(kept_truth, [&] { return true_disparity(grid, poses.cameras, depths, job); });
  lap("truth");
  save(pictures, "truth.png", truth);
  const auto upright = rectify(frames, poses.cameras, poses.frame_of_camera, poses.points, fit.arc, 1, job);
  lap("rectify");
  for (const auto& frame : upright)
    std::printf("%.3f/%.3f/%.3f ", static_cast<double>(frame.gain[0]), static_cast<double>(frame.gain[1]),
                static_cast<double>(frame.gain[2]));
  std::printf("\n");
  const CostVolume sweep(upright, grid, {}, {}, {});
  Plane<uint8_t> grey, least;
  const auto cheapest = cheapest_labels(sweep, grey, least);
  lap("sweep");
  report("cheapest", of_labels(cheapest), truth);
  save(pictures, "cheapest.png", of_labels(cheapest));
  if (!pictures.empty()) {
    write_file(fs::path(pictures) / "grey.png", encode_png(grey));
    write_file(fs::path(pictures) / "cost.png", encode_png(least));
  }
#ifdef HAVE_SOLVE
  const Labelling cut = solve_depth(sweep, {}, {}, job);
  lap("solve");
  report("cut", of_labels(cut.labels), truth);
  save(pictures, "cut.png", of_labels(cut.labels));
  const Plane<uint8_t>& labels = cut.labels;
#else
  const Plane<uint8_t>& labels = cheapest;
#endif
  const DisparityMap refined = refine(sweep, labels, {}, job);
  lap("refine");
  report("refined", refined, truth);
  save(pictures, "refined.png", refined);
  return 0;
}

}  // namespace
}  // namespace ldp

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: depth_bench CAPTURE [--central] [--pictures DIR] [--truth FILE]\n");
    return 2;
  }
  ldp::Rays rays = ldp::Rays::pushbroom;
  std::string pictures, kept_truth;
  for (int i = 2; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--central")) rays = ldp::Rays::central;
    if (!std::strcmp(argv[i], "--pictures") && i + 1 < argc) pictures = argv[++i];
    if (!std::strcmp(argv[i], "--truth") && i + 1 < argc) kept_truth = argv[++i];
  }
  return ldp::run(argv[1], rays, pictures, kept_truth);
}
