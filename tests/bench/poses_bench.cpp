// Poses of the data sets: how many frames, how far from truth where truth is known, how long.
//
//   poses_bench                            the table over every data set
//   poses_bench --sweeps N [--first SEED] [--size WxH] [--scene NAME] [--cache DIR] [--fov-factor FACTOR]
//               [--crowd SHARE] [--distorted] N synthetic sweeps of every kind, a table and the failures by name; the
//                                          field of view is told so many times too wide, or not at all; people who walk
//                                          by hide that share (0 .. 0.5) of each sweep's fullest picture; the lens
//                                          distorts as real ones do (k1 -.12 .. .04) instead of not at all
//   poses_bench FOLDER [--fov DEGREES] [--cameras transforms.json] [--threads N] [-o transforms.json] [-v]
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <stdexcept>

#include "core/arc/arc.h"
#include "core/base/files.h"
#include "core/photos/images.h"
#include "core/poses/poses.h"
#include "sim/scene/scenes.h"
#include "sim/scene_capture.h"

namespace {

using namespace ldp;
namespace fs = std::filesystem;
constexpr double kDegree = std::numbers::pi / 180;

class Folder : public FrameSource {
 public:
  explicit Folder(const fs::path& folder) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string extension = entry.path().extension();
      if (extension == ".jpg" || extension == ".png" || extension == ".JPG") files_.push_back(entry.path());
    }
    std::sort(files_.begin(), files_.end());
  }
  int size() const override { return static_cast<int>(files_.size()); }
  std::string name(int i) const override { return files_[static_cast<size_t>(i)].filename(); }
  RgbImage load(int i) const override { return read_image(files_[static_cast<size_t>(i)]); }
  std::optional<double> focal_hint(int i) const override {
    return read_photo(files_[static_cast<size_t>(i)]).focal_hint;
  }

 private:
  std::vector<fs::path> files_;
};

// OpenGL axes (x right, y up, z back) in the file, OpenCV's in the program.
std::vector<Camera> read_cameras(const fs::path& file) {
  const nlohmann::json json = nlohmann::json::parse(std::ifstream(file));
  Intrinsics k{json["w"], json["h"], json["fl_x"], json["fl_y"], json["cx"], json["cy"]};
  k.k1 = json.value("k1", 0.0), k.k2 = json.value("k2", 0.0), k.p1 = json.value("p1", 0.0),
  k.p2 = json.value("p2", 0.0);
  std::vector<Camera> cameras;
  for (const auto& frame : json["frames"]) {
    Camera camera{fs::path(frame["file_path"].get<std::string>()).filename(), k, {}};
    for (int row = 0; row < 3; ++row) {
      const auto& m = frame["transform_matrix"][static_cast<size_t>(row)];
      camera.pose.world_from_camera.row(row) << m[0].get<double>(), -m[1].get<double>(), -m[2].get<double>();
      camera.pose.centre[row] = m[3];
    }
    cameras.push_back(camera);
  }
  return cameras;
}

void write_cameras(const fs::path& file, const std::vector<Camera>& cameras) {
  const Intrinsics& k = cameras.at(0).intrinsics;
  nlohmann::json json{{"camera_model", "OPENCV"},
                      {"fl_x", k.fx},
                      {"fl_y", k.fy},
                      {"cx", k.cx},
                      {"cy", k.cy},
                      {"w", k.width},
                      {"h", k.height},
                      {"k1", k.k1},
                      {"k2", k.k2},
                      {"p1", k.p1},
                      {"p2", k.p2}};
  for (const Camera& camera : cameras) {
    nlohmann::json matrix;
    for (int row = 0; row < 3; ++row) {
      const Eigen::RowVector3d r = camera.pose.world_from_camera.row(row);
      matrix.push_back({r[0], -r[1], -r[2], camera.pose.centre[row]});
    }
    matrix.push_back({0, 0, 0, 1});
    json["frames"].push_back({{"file_path", camera.name}, {"transform_matrix", matrix}});
  }
  std::ofstream(file) << json.dump(1) << "\n";
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

struct Score {
  double centre_median = 0, centre_max = 0, rotation_median = 0, focal = 0;  // % of the radius, %, degrees, %
};

// As evaluate.py does: rotation of the alignment from the orientations, scale and shift from the centres.
Score score(const std::vector<Camera>& found, const std::vector<Camera>& truth) {
  std::vector<std::pair<Camera, Camera>> both;
  for (const Camera& t : truth) {
    for (const Camera& f : found) {
      if (f.name == t.name) both.emplace_back(f, t);
    }
  }
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;
  for (const auto& [f, t] : both) {
    m += t.pose.world_from_camera * f.pose.world_from_camera.transpose();
    a += f.pose.centre / static_cast<double>(both.size());
    b += t.pose.centre / static_cast<double>(both.size());
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
  double above = 0, below = 0;
  for (const auto& [f, t] : both) {
    above += (t.pose.centre - b).dot(turn * (f.pose.centre - a));
    below += (f.pose.centre - a).squaredNorm();
  }
  const double radius = fit_arc(truth).arc.radius;
  std::vector<double> centres, turns;
  for (const auto& [f, t] : both) {
    centres.push_back((above / below * turn * (f.pose.centre - a) + b - t.pose.centre).norm() / radius * 100);
    turns.push_back(Eigen::AngleAxisd(t.pose.world_from_camera.transpose() * turn * f.pose.world_from_camera).angle() /
                    kDegree);
  }
  const Intrinsics &kf = both[0].first.intrinsics, &kt = both[0].second.intrinsics;
  return {median(centres), *std::max_element(centres.begin(), centres.end()), median(turns),
          100 * std::abs(kf.fx / kf.width / (kt.fx / kt.width) - 1)};
}

struct Arguments {
  fs::path folder, cameras, output, cache;
  std::string scene;
  double fov = 0, fov_factor = 0, crowd = 0;
  int threads = 2, sweeps = 0, width = 640, height = 480;
  unsigned first = 1;
  bool verbose = false, distorted = false;
};

const char* word(Motion motion) {
  return motion == Motion::arc ? "arc" : motion == Motion::straight ? "straight" : "rotation";
}

void print_frames(const PosesReport& report) {
  for (const FrameReport& f : report.frames) {
    std::printf("    %-16s %-7s features %5d matches %5d inliers %5d  %.3f px  %s\n", f.name.c_str(),
                f.posed ? "posed" : "DROPPED", f.features, f.matches, f.inliers, f.reprojection_px,
                words_of(f.left_out).c_str());
  }
}

void print_arc(const std::vector<Camera>& cameras, const std::vector<ScenePoint>& points) {
  const ArcFit fit = fit_arc(cameras);
  double radial = 0, height = 0;
  for (const double r : fit.radial_residuals) radial = std::max(radial, std::abs(r));
  for (const double h : fit.height_residuals) height = std::max(height, std::abs(h));
  const PanoramaGrid grid = lay_grid(fit.arc, cameras, points, GridOptions{});
  std::printf(
      "    arc: radius %.3f, %.1f to %.1f deg%s%s, worst radial %.3f height %.3f; grid %dx%d%s, depth %.2f to %.2f\n",
      fit.arc.radius, fit.arc.theta_begin / kDegree, fit.arc.theta_end / kDegree, fit.arc.closed ? ", closed" : "",
      fit.straight ? ", straight" : "", radial, height, grid.width, grid.height, grid.wraps ? " wraps" : "",
      1 / grid.w_near, 1 / grid.w_far);
}

void run(const Arguments& arguments) {
  const Folder folder(arguments.folder);
  PosesOptions options;
  if (arguments.fov > 0) options.fov_rad = arguments.fov * kDegree;
  Job job;
  job.threads = arguments.threads;
  const auto start = std::chrono::steady_clock::now();
  const clock_t cpu = std::clock();
  const Poses poses = arguments.cameras.empty() ? estimate_poses(folder, options, job)
                                                : triangulate(folder, read_cameras(arguments.cameras), options, job);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const PosesReport& report = poses.report;
  std::printf("%-28s %2zu/%2d posed, %s%s, %5d points, %.3f px, f/w %.4f k1 %.4f k2 %.4f, %.2f s (%.2f s CPU)\n",
              arguments.folder.parent_path().filename() == "garden" ? "garden" : arguments.folder.filename().c_str(),
              poses.cameras.size(), folder.size(), word(report.motion), report.closed ? " closed" : "", report.points,
              report.reprojection_px, poses.cameras[0].intrinsics.fx / poses.cameras[0].intrinsics.width,
              poses.cameras[0].intrinsics.k1, poses.cameras[0].intrinsics.k2, seconds,
              static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  for (const fs::path& truth :
       {arguments.folder / "transforms.json", arguments.folder.parent_path() / "transforms.json"}) {
    if (!fs::exists(truth) || !arguments.cameras.empty()) continue;
    const Score s = score(poses.cameras, read_cameras(truth));
    std::printf(
        "    against truth: centre median %.2f %% max %.2f %% of the radius, rotation median %.4f deg, focal %.2f %%\n",
        s.centre_median, s.centre_max, s.rotation_median, s.focal);
  }
  print_arc(poses.cameras, poses.points);
  if (!report.doubt.empty()) std::printf("    doubt: %s\n", report.doubt.c_str());
  if (arguments.verbose) print_frames(report);
  if (!arguments.output.empty()) write_cameras(arguments.output, poses.cameras);
}

void run_all(Arguments arguments) {
  const fs::path data = LDP_SHARED_DATA;
  for (const char* name :
       {"scenes/garden/frames", "photos/redkitchen_arc", "photos/courtyard_360", "photos/atrium_360",
        "photos/desk_sweep", "photos/kitchen_sideways", "photos/apartment_dolly", "photos/arcade_rotation_only"}) {
    arguments.folder = data / name;
    try {
      run(arguments);
    } catch (const Impossible& e) {
      std::printf("%-28s impossible: %s\n", arguments.folder.filename().c_str(), e.what());
    }
    std::fflush(stdout);
  }
}

// Synthetic photographs, rendered when they are asked for, or taken from a folder that an earlier run left them in:
// rendering takes ten times as long as posing.
class Synthetic : public FrameSource {
 public:
  Synthetic(const SceneCaptureOptions& options, const fs::path& cache) : sweep_(options) {
    if (cache.empty()) return;
    cache_ = cache / (options.scene + "_" + std::to_string(options.seed) + "_" + std::to_string(options.path.width) +
                      (options.crowd > 0 ? "_crowd" + std::to_string(options.crowd) : "") +
                      (options.path.k1 != 0 ? "_distorted" : ""));
    fs::create_directories(cache_);
  }
  int size() const override { return static_cast<int>(sweep_.cameras().size()); }
  std::string name(int i) const override { return sweep_.cameras()[static_cast<size_t>(i)].name; }
  RgbImage load(int i) const override {
    const fs::path file = cache_ / name(i);
    const bool cached = !cache_.empty() && fs::exists(file);
    RgbImage image = cached ? read_image(file) : sweep_.take(i, Job{}).colour;
    if (!cached && !cache_.empty()) write_file(file, encode_png(image));
    return image;
  }
  std::optional<double> focal_hint(int) const override { return std::nullopt; }
  const std::vector<Camera>& truth() const { return sweep_.cameras(); }

 private:
  SceneSweep sweep_;
  fs::path cache_;
};

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
}

// Everything that varies from sweep to sweep follows from the seed. Frames are as many as give 60 to 85 % overlap, 8
// to 40, in the room on its wall 1 m from the camera, as whoever picks frames by overlap picks them; where 40 are too
// few for that, the view is wider. `repeated`, where everything looks like its neighbour, is a trial of its own
// (--scene).
SceneCaptureOptions random_sweep(unsigned seed, const std::string& scene, bool distorted) {
  std::mt19937 random(seed);
  constexpr double kArcs[] = {30, 60, 120, 180, 300, 360};
  SceneCaptureOptions options;
  options.seed = seed;
  std::vector<std::string> scenes = scene_names();
  std::erase(scenes, "repeated");
  options.scene = scenes[random() % scenes.size()];
  if (!scene.empty()) options.scene = scene;
  SweepPath& path = options.path;
  path.seed = seed;
  path.arc_rad = kArcs[random() % 6] * kDegree;
  const bool room = options.scene == "room";
  path.radius = between(random, 0.3, room ? 0.7 : 1.0);
  const double swept = path.arc_rad * (room ? 1 + path.radius : 1);  // how far the picture moves, by angle
  path.fov_rad = std::max(between(random, 24, 90) * kDegree, swept / (39 * 0.4));
  path.frames = std::clamp(static_cast<int>(swept / (path.fov_rad * between(random, 0.15, 0.4))) + 1, 8, 40);
  path.position_jitter = between(random, 0, 0.05 / 3);  // deviations: three of them reach 5 cm and 4 degrees
  path.angle_jitter_rad = between(random, 0, 4.0 / 3) * kDegree;
  options.noise = between(random, 0, 4);
  options.blur_px = between(random, 0, 2);
  options.exposure_drift = between(random, 0, 0.4);
  options.moving_share = 0.1;
  if (distorted) path.k1 = between(random, -0.12, 0.04);  // drawn last: all else is as without
  return options;
}

bool run_sweep(unsigned seed, const Arguments& arguments) {
  SceneCaptureOptions options = random_sweep(seed, arguments.scene, arguments.distorted);
  SweepPath& path = options.path;
  path.width = arguments.width, path.height = arguments.height;
  options.crowd = arguments.crowd;
  std::printf("%3u %-10s arc %3.0f fov %2.0f frames %2d radius %.2f jitter %.1f cm %.1f deg", seed,
              options.scene.c_str(), path.arc_rad / kDegree, path.fov_rad / kDegree, path.frames, path.radius,
              100 * path.position_jitter, path.angle_jitter_rad / kDegree);
  if (path.k1 != 0) std::printf(" k1 %.3f", path.k1);
  std::printf(": ");
  const Synthetic source(options, arguments.cache);
  Job job;
  job.threads = arguments.threads;
  bool good = false;
  try {
    PosesOptions told;
    if (arguments.fov_factor > 0) told.fov_rad = arguments.fov_factor * path.fov_rad;
    const Poses poses = estimate_poses(source, told, job);
    const Score s = score(poses.cameras, source.truth());
    good = poses.cameras.size() == source.truth().size() && s.centre_median < 2 && s.rotation_median < 0.1;
    std::printf("%s %zu posed, %s%s, %.2f px, centre %.2f %% (max %.2f), rotation %.3f deg, focal %.2f %%\n",
                good ? "good  " : "FAILED", poses.cameras.size(), word(poses.report.motion),
                poses.report.closed ? " closed" : "", poses.report.reprojection_px, s.centre_median, s.centre_max,
                s.rotation_median, s.focal);
    if (!poses.report.doubt.empty()) std::printf("    doubt: %s\n", poses.report.doubt.c_str());
    if (arguments.verbose) print_frames(poses.report);
  } catch (const Impossible& e) {
    std::printf("FAILED impossible: %s\n", e.what());
  }
  std::fflush(stdout);
  return good;
}

void run_sweeps(const Arguments& arguments) {
  int good = 0;
  for (int i = 0; i < arguments.sweeps; ++i)
    good += run_sweep(arguments.first + static_cast<unsigned>(i), arguments) ? 1 : 0;
  std::printf("%d of %d sweeps: every frame posed, centre median < 2 %%, rotation median < 0.1 deg\n", good,
              arguments.sweeps);
}

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    const auto value = [&] { return i + 1 < argc ? argv[++i] : throw std::runtime_error(a + " needs a value"); };
    if (a == "--fov")
      arguments.fov = std::stod(value());
    else if (a == "--fov-factor")
      arguments.fov_factor = std::stod(value());
    else if (a == "--cameras")
      arguments.cameras = value();
    else if (a == "--threads")
      arguments.threads = std::stoi(value());
    else if (a == "-o")
      arguments.output = value();
    else if (a == "--sweeps")
      arguments.sweeps = std::stoi(value());
    else if (a == "--first")
      arguments.first = static_cast<unsigned>(std::stoi(value()));
    else if (a == "--scene")
      arguments.scene = value();
    else if (a == "--crowd")
      arguments.crowd = std::stod(value());
    else if (a == "--cache")
      arguments.cache = value();
    else if (a == "--size") {
      if (std::sscanf(value(), "%dx%d", &arguments.width, &arguments.height) != 2)
        throw std::runtime_error("--size wants WIDTHxHEIGHT");
    } else if (a == "-v")
      arguments.verbose = true;
    else if (a == "--distorted")
      arguments.distorted = true;
    else
      arguments.folder = a;
  }
  if (!(arguments.crowd >= 0 && arguments.crowd <= 0.5)) throw std::runtime_error("--crowd wants a share of 0 to 0.5");
  return arguments;
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments arguments = parse(argc, argv);
  if (arguments.sweeps > 0)
    run_sweeps(arguments);
  else if (arguments.folder.empty())
    run_all(arguments);
  else
    run(arguments);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "poses_bench: %s\n", e.what());
  return 1;
}
