#include "core/pipeline/build.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "core/arc/arc.h"
#include "core/base/exact_math.h"
#include "core/colour/colour.h"
#include "core/consistency/consistency.h"
#include "core/layers/layers.h"
#include "core/pipeline/debug_pictures.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/pose_evidence.h"
#include "core/pipeline/stage_order.h"
#include "core/rectify/rectify.h"
#include "core/sweep/cost_volume.h"
#include "core/verdict/judge.h"
#include "core/verdict/rephotography.h"

namespace ldp {
namespace {

void require(bool sound, const std::string& field, int value, const std::string& bounds) {
  if (!sound) throw std::logic_error("BuildOptions: " + field + " is " + std::to_string(value) + ", must be " + bounds);
}

void check(const BuildOptions& options) {
  require(options.layers >= 1 && options.layers <= 8, "layers", options.layers, "1 .. 8");
  require(options.labels >= 2 && options.labels <= kLabels, "labels", options.labels, "2 .. 16");
  require(options.iterations >= 1 && options.iterations <= 4, "iterations", options.iterations, "1 .. 4");
  require(options.block_px >= 0, "block_px", options.block_px, "0 or more");
}

constexpr double kCoarser = 1.05, kCoarsest = 3;  // steps of the panorama's pitch, and its limit, to save memory
constexpr double kFull = 0.75;  // share of the memory allowed at which large arrays are let go: it takes a moment
// Message passing and expansion of every cut. As many cycles as find something take longer for views as good.
constexpr int kIterations = 4, kCycles = 1;
// What an iteration before the last finds only hides voxels: it is swept in fewer steps, with less message passing, and
// not expanded at all. Views are as good as with all of it, for half of its time (with 4, 2 and 1 iterations garden
// 20.27, 20.28, 20.26 dB, redkitchen_arc 22.96, 23.03, 23.03, desk_sweep 20.34, 20.51, 20.44).
constexpr int kHidingSubsteps = 4, kHidingIterations = 2, kHidingCycles = 0;
// Parallax over one arc radius to which depths are known; behind the front, where fewer cameras see, to twice as much.
constexpr double kKnownPx = 2.5;
// What lies less behind the surface in front of it is not kept: within the viewing space it shows by half as much, as a
// rim that a renderer gets by letting the background go on underneath.
constexpr double kSeparatePx = 10;
constexpr int kSpeckPx = 8;       // parts of layers behind that hold fewer pixels are not kept
constexpr int kSilhouettePx = 4;  // by so much the sweep's windows may widen a near surface, and the cut a little more

// Adds the time since its making, or since the last lap, to a stage of the report.
class Stopwatch {
 public:
  explicit Stopwatch(BuildReport& report) : report_(report) {}
  void lap(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    for (auto& [name, sum] : report_.seconds)
      if (name == stage) {
        sum += seconds;
        return;
      }
    report_.seconds.emplace_back(stage, seconds);
  }

 private:
  BuildReport& report_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// What a build knows so far. Disparity maps stand for layers until their colours are fetched.
class Build {
 public:
  Build(const FrameSource& frames, const BuildOptions& options, const Job& job, PoseEstimator begun)
      : frames_(frames),
        options_(options),
        job_(job),
        watch_(report_),
        pictures_(options.debug_directory),
        begun_(std::move(begun)) {}

  BuildResult run() { return run_in_order(*this, options_.layers, options_.iterations); }

 private:
  template <typename Stages>
  friend auto ldp::run_in_order(Stages& stages, int layers, int iterations);
  template <typename Stages>
  friend void ldp::find_layers_in_order(Stages& stages, int layers, int iterations);

  void find_cameras() {
    poses_ = options_.cameras.empty() ? estimate_poses(frames_, std::move(begun_), job_)
                                      : triangulate(frames_, options_.cameras, options_.poses, job_);
    if (!poses_.report.doubt.empty()) report_.notes.push_back("the poses may be wrong: " + poses_.report.doubt);
    watch_.lap("poses");
  }

  void lay_out() {
    report_.arc = fit_arc(poses_.cameras);
    if (const std::string what = sideways(poses_.cameras); !what.empty()) report_.notes.push_back(what);
    GridOptions grid;
    grid.rays = options_.rays;
    grid.near_depth = options_.near_depth;
    grid.far_depth = options_.far_depth;
    watch_.lap("arc");
    lay_finest_grid(grid);
    check_range();
    watch_.lap("arc");
    upright_ =
        rectify(frames_, poses_.cameras, poses_.frame_of_camera, poses_.points, report_.arc.arc, grid.pitch_px, job_);
    watch_.lap("rectify");
    if (grid.near_depth == 0 && parallax()) take_in_what_is_nearer(grid);
    watch_.lap("depth range");
  }

  // Lays the finest grid that fits the memory allowed.
  void lay_finest_grid(GridOptions& options) {
    while (!lay(options)) {
      if (options.pitch_px > kCoarsest)
        throw Impossible("this sweep needs at least " + mebibytes(scratch_ ? needed_.least : needed_.all) +
                         " of memory, " + mebibytes(options_.memory_bytes) +
                         " are allowed (memory_bytes): allow more or use smaller photos");
      options.pitch_px *= kCoarser;
    }
    if (options.pitch_px > 1)
      report_.notes.push_back("to fit the memory allowed, a row of the panorama spans " +
                              std::to_string(options.pitch_px).substr(0, 4) + " of the photos'");
  }

  // A depth that was asked for may lie on the wrong side of the one that the photos tell.
  void check_range() const {
    if (!parallax() || grid_.w_far < grid_.w_near) return;
    const bool far_given = options_.far_depth > 0;
    const auto text = [](double value) {
      char digits[32];
      std::snprintf(digits, sizeof digits, "%.4g", value);
      return std::string(digits);
    };
    throw std::invalid_argument(
        (far_given ? "far_depth " + text(options_.far_depth) : "near_depth " + text(options_.near_depth)) +
        (far_given ? ": is nearer than what is nearest in the photos, at "
                   : ": is farther than what is farthest in the photos, at ") +
        text(1 / (far_given ? grid_.w_near : grid_.w_far)) +
        (far_given ? ": give a larger one, or near_depth too" : ": give a smaller one, or far_depth too"));
  }

  // Whether the grid fits the memory allowed; what does not fit goes to files where it may.
  bool lay(const GridOptions& options) {
    const size_t allowed = options_.memory_bytes > 0 ? options_.memory_bytes : kEasyMemory;
    const Intrinsics& k = poses_.cameras.front().intrinsics;
    const size_t photo_px = static_cast<size_t>(k.width) * static_cast<size_t>(k.height);
    grid_ = lay_grid(report_.arc.arc, poses_.cameras, poses_.points, options);
    columns_of_colour_ = columns_of_colour(grid_, poses_.cameras, poses_.points);
    needed_ = expected_memory(grid_, columns_of_colour_, photo_px,
                              upright_pixels(poses_.cameras, report_.arc.arc, options.pitch_px), options_.layers);
    if (needed_.all > allowed && !std::exchange(tried_scratch_, true)) open_scratch(allowed);
    return options_.memory_bytes == 0 || (scratch_ ? needed_.least : needed_.all) <= allowed;
  }

  // What is nearer than the feature points tell widens the range, and the grid a little; not where memory does not
  // allow it. (Scratch files cannot take the upright frames any more.)
  void take_in_what_is_nearer(GridOptions options) {
    const PanoramaGrid laid = grid_;
    const int columns_laid = columns_of_colour_;
    options.matched_near = matched_near(upright_, grid_, job_);
    tried_scratch_ = true;
    if (options.matched_near > grid_.w_near && !lay(options)) grid_ = laid, columns_of_colour_ = columns_laid;
  }

  void open_scratch(size_t allowed) {
    if (options_.scratch_directory.empty()) return;
    try {
      scratch_ = std::make_unique<ScratchSpace>(options_.scratch_directory,
                                                static_cast<size_t>(kFull * static_cast<double>(allowed)));
    } catch (const std::runtime_error& error) {
      report_.notes.push_back(std::string("everything is kept in memory: ") + error.what());
    }
  }

  static std::string mebibytes(size_t bytes) {
    if (bytes < 1 << 20) return std::to_string(bytes) + " bytes";
    return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
  }

  bool parallax() const { return poses_.report.motion != Motion::rotation; }

  void one_far_layer() {
    report_.notes.push_back("no parallax was found: one far layer");
    grid_.w_near = grid_.w_far = 0;
    layers_.assign(1, DisparityMap(grid_.width, grid_.height, 0));
  }

  void begin_iteration(bool last) { last_ = last; }

  // False when no camera sees anything behind the layers found so far.
  bool find_layer(int index, const std::string& name) {
    job_.report(name, 0);
    DisparityMap layer = index == 0 ? front_layer(name) : layer_behind(found_, name);
    if (layer.empty()) return false;
    pictures_.disparity(name, layer);
    if (last_) add_layer(grid_, layer, upright_, {}, job_, visibility_);
    watch_.lap("visibility");
    found_.push_back(std::move(layer));
    return true;
  }

  void end_iteration() { layers_ = std::exchange(found_, {}); }

  void check_layers() const {
    if (layers_.empty())
      throw Impossible(std::string("no two photos show the same thing at any depth") +
                       (options_.cameras.empty() ? "" : ": are the cameras given those of these photos?"));
  }

  // What the front layer of the iteration before surely hides.
  std::vector<VisibilityMap> sure_visibility() {
    std::vector<VisibilityMap> maps;
    if (layers_.empty()) return maps;
    add_layer(grid_, without_silhouettes(layers_[0], kSilhouettePx), upright_, {}, job_, maps);
    watch_.lap("visibility");
    return maps;
  }

  DisparityMap front_layer(const std::string& name) {
    const std::vector<VisibilityMap> hiding = sure_visibility();
    SweepOptions options = sweep_options();
    options.points = &poses_.points;
    const CostVolume sweep(upright_, grid_, hiding, DisparityMap(), options);
    const Plane<uint8_t> labels = solve(sweep, Plane<uint8_t>(), name);
    DisparityMap disparity = refine(sweep, labels, {}, job_);
    watch_.lap("refine");
    if (last_) fit_outlines(grid_, upright_, job_, disparity);  // what only hides does so inside its outlines
    watch_.lap("outlines");
    return disparity;
  }

  // Empty when no camera sees anything behind the layers found so far.
  DisparityMap layer_behind(const std::vector<DisparityMap>& found, const std::string& name) {
    DisparityMap surface = deepest(found);
    const Plane<uint8_t> want = wanted_behind(grid_, surface, {upright_, visibility_}, {}, job_);
    pictures_.labels("wanted " + name, want, 2);
    watch_.lap("visibility");
    if (std::none_of(want.samples.begin(), want.samples.end(), [](uint8_t w) { return w == kWanted; })) return {};
    const DisparityMap limit = sweep_limit(surface, want);
    const CostVolume sweep(upright_, grid_, visibility_, limit, sweep_options());
    const BoundaryCosts costs(sweep, want, surface);
    const Plane<uint8_t> labels = solve(costs, want, name);
    DisparityMap layer = refine(sweep, labels, want, job_);
    const int gap = gap_steps(grid_, {});
    for (size_t i = 0; i < layer.samples.size(); ++i) {
      const bool behind = layer.samples[i] + gap <= surface.samples[i];
      if (want.samples[i] != kWanted || !behind) layer.samples[i] = kNoDisparity;
    }
    continue_background(want, surface, gap, layer);
    watch_.lap("refine");
    move_to_visible(grid_, surface, gap, {upright_, visibility_}, want, job_, layer);
    drop_unseen(grid_, {upright_, visibility_}, job_, layer);
    watch_.lap("visibility");
    return layer;
  }

  // Behind what a pixel is swept: the surface; nothing at all where it is not wanted; and as far as the label at which
  // it is held where it is boundary.
  DisparityMap sweep_limit(const DisparityMap& surface, const Plane<uint8_t>& want) const {
    const int label = kDisparitySteps / (options_.labels - 1) + 1;
    DisparityMap limit = surface;
    for (size_t i = 0; i < limit.samples.size(); ++i) {
      if (want.samples[i] == kUnwanted) limit.samples[i] = 0;
      if (want.samples[i] == kBoundary) limit.samples[i] = static_cast<uint16_t>(limit.samples[i] + label);
    }
    return limit;
  }

  static DisparityMap deepest(const std::vector<DisparityMap>& found) {
    DisparityMap surface = found[0];
    for (size_t k = 1; k < found.size(); ++k)
      for (size_t i = 0; i < surface.samples.size(); ++i)
        if (found[k].samples[i] != kNoDisparity) surface.samples[i] = found[k].samples[i];
    return surface;
  }

  SweepOptions sweep_options() const {
    SweepOptions sweep;
    sweep.labels = options_.labels;
    if (!last_) sweep.substeps = kHidingSubsteps;
    return sweep;
  }

  Plane<uint8_t> solve(const CostSource& costs, const Plane<uint8_t>& mask, const std::string& name) {
    SolveOptions solving;
    solving.iterations = last_ ? kIterations : kHidingIterations;
    solving.cycles = last_ ? kCycles : kHidingCycles;
    Labelling labelling = solve_depth(costs, mask, solving, job_);
    report_.solves.push_back({"depth " + name, labelling.report});
    pictures_.labels("labels " + name, labelling.labels, options_.labels - 1);
    watch_.lap("solve");
    return std::move(labelling.labels);
  }

  // What follows is done on the grid on which colours are stored.
  void split_columns() {
    if (columns_of_colour_ == 1) return;
    for (DisparityMap& layer : layers_) layer = with_finer_columns(layer, columns_of_colour_, grid_.wraps);
    grid_ = with_finer_columns(grid_, columns_of_colour_);
  }

  void choose_photographs() {
    pictures_.visibility("visibility", visibility_);
    for (size_t k = 0; k < layers_.size(); ++k) {
      ColourOptions colour;
      colour.guess_hidden = k == 0;
      const SourceCandidates candidates(grid_, layers_[k], upright_, visibility_, colour);
      ColourSolveOptions solving;
      solving.iterations = kIterations;
      solving.cycles = kCycles;
      ColourSolve solved = solve_colour(candidates, solving, job_);
      const std::string name = "colour layer " + std::to_string(k + 1);
      report_.solves.push_back({name, solved.report});
      pictures_.sources("sources layer " + std::to_string(k + 1), solved.sources);
      drop_colourless(solved.sources, layers_[k]);
      neighbours_.push_back(candidates.neighbours(solved.sources, job_));
      sources_.push_back(std::move(solved.sources));
    }
    std::vector<VisibilityMap>().swap(visibility_);
    watch_.lap("colour cut");
  }

  static void drop_colourless(const SourceMap& source, DisparityMap& layer) {
    for (int y = 0; y < layer.height; ++y)
      for (int x = 0; x < layer.width; ++x)
        if (source.at(x, y) == kNoSource) layer.at(x, y) = kNoDisparity;
  }

  BuildResult assemble() {
    BuildResult result;
    LayeredPanorama& panorama = result.panorama;
    panorama.grid = grid_;
    panorama.cameras = poses_.cameras;
    panorama.limits = viewing_limits();
    panorama.layers = coded_layers();
    fetch(panorama.layers);
    for (size_t k = 0; k < layers_.size(); ++k) {
      const auto present =
          std::count(panorama.layers[k].coverage.samples.begin(), panorama.layers[k].coverage.samples.end(), 1);
      report_.coverage.push_back(static_cast<double>(present) / static_cast<double>(layers_[k].samples.size()));
      pictures_.colour("colour layer " + std::to_string(k + 1), panorama.layers[k].colour);
    }
    hold_against_photographs(panorama);
    report_.poses = poses_.report;
    add_pose_evidence(poses_, frames_.size(), report_.evidence);
    report_.quality = judge(report_.evidence);
    panorama.quality = figures_of(report_.quality);
    watch_.lap("verdict");
    result.report = std::move(report_);
    result.scratch = std::move(scratch_);
    return result;
  }

  std::vector<Layer> coded_layers() {
    std::vector<Layer> layers;
    Plane<int16_t> farthest(grid_.width, grid_.height, kDisparitySteps);  // disparity at most that the next layer shows
    for (size_t k = 0; k < layers_.size(); ++k) {
      drop_inseparable(farthest, layers_[k]);
      if (k > 0) drop_small_components(kSpeckPx * columns_of_colour_, grid_.wraps, layers_[k]);
      drop_sources(layers_[k], sources_[k]);
      layers.push_back(coded(layers_[k], k == 0 ? kKnownPx : 2 * kKnownPx));
      move_back(layers[k], farthest);
    }
    return layers;
  }

  int steps_of_parallax(double px) const {
    LayersOptions options;
    options.gap_px = px;
    return gap_steps(grid_, options);
  }

  static void drop_inseparable(const Plane<int16_t>& farthest, DisparityMap& layer) {
    for (size_t i = 0; i < layer.samples.size(); ++i)
      if (layer.samples[i] != kNoDisparity && layer.samples[i] > farthest.samples[i]) layer.samples[i] = kNoDisparity;
  }

  static void drop_sources(const DisparityMap& layer, SourceMap& source) {
    for (int y = 0; y < layer.height; ++y)
      for (int x = 0; x < layer.width; ++x)
        if (layer.at(x, y) == kNoDisparity) source.set(x, y, kNoSource);
  }

  // Surfaces less than two codes apart are one to a renderer.
  void move_back(const Layer& layer, Plane<int16_t>& farthest) const {
    const int separate = steps_of_parallax(kSeparatePx);
    for (int y = 0; y < grid_.height; ++y)
      for (int x = 0; x < grid_.width; ++x) {
        if (!layer.coverage.at(x, y)) continue;
        const BlockRange range = layer.depth.range(x, y);
        const int apart = std::max(separate, 2 * (range.high - range.low));
        farthest.at(x, y) = static_cast<int16_t>(layer.depth.disparity(x, y) - apart);
      }
  }

  Layer coded(const DisparityMap& disparity, double known_px) const {
    Layer layer;
    layer.depth = encode_depth(disparity, options_.block_px, steps_of_parallax(known_px));
    layer.coverage = Plane<uint8_t>(grid_.width, grid_.height, 0);
    for (size_t i = 0; i < disparity.samples.size(); ++i)
      layer.coverage.samples[i] = disparity.samples[i] != kNoDisparity;
    layer.colour = RgbImage(grid_.width, grid_.height);
    return layer;
  }

  void fetch(std::vector<Layer>& layers) {
    for (size_t i = 0; i < upright_.size(); ++i) {
      gains_.push_back(upright_[i].gain);
      report_.gains[poses_.cameras[i].name] = upright_[i].gain;
    }
    const Photographs photographs{frames_, poses_.cameras, poses_.frame_of_camera, gains_};
    std::vector<UprightFrame>().swap(upright_);  // the colours need their memory
    std::vector<ColourTask> tasks;
    for (size_t k = 0; k < layers.size(); ++k)
      tasks.push_back({&layers_[k], &sources_[k], &layers[k].colour, &neighbours_[k]});
    blend_colours(grid_, photographs, tasks, {}, job_);
    watch_.lap("colour");
  }

  void hold_against_photographs(const LayeredPanorama& panorama) {
    std::vector<SourceMap>().swap(sources_);
    std::vector<Plane<uint8_t>>().swap(neighbours_);
    std::vector<DisparityMap>().swap(layers_);
    AgreementSink sink;
    if (pictures_.wanted())
      sink = [&](const std::string& photo, const Plane<uint8_t>& map) {
        pictures_.agreement("agreement " + photo, map);
      };
    Rephotography rephotography(grid_, poses_.cameras, gains_, job_, report_.evidence);
    report_.consistency =
        hold_against({frames_, poses_.frame_of_camera, gains_}, panorama, {}, job_, sink, &rephotography);
    watch_.lap("consistency");
  }

  // The cameras' own spread about the arc, and a margin of half the radius, within which holes stay small.
  ViewingLimits viewing_limits() const {
    const Arc& arc = grid_.arc;
    double height = 0;
    for (const Camera& camera : poses_.cameras)
      height = std::max(height, std::abs(exact_dot(camera.pose.centre - arc.centre, arc.axis())));
    return {0.5 * arc.radius, 1.25 * arc.radius, height + 0.1 * arc.radius};
  }

  const FrameSource& frames_;
  const BuildOptions& options_;
  const Job& job_;
  BuildReport report_;
  Stopwatch watch_;
  DebugPictures pictures_;
  PoseEstimator begun_;
  std::unique_ptr<ScratchSpace> scratch_;
  Poses poses_;
  PanoramaGrid grid_;
  ExpectedMemory needed_;  // for the grid laid last
  bool tried_scratch_ = false;
  int columns_of_colour_ = 1;  // to each of the columns in which depths are found
  std::vector<UprightFrame> upright_;
  bool last_ = true;                          // is this the last iteration?
  std::vector<DisparityMap> layers_, found_;  // of the last iteration that ended, of the present one
  std::vector<VisibilityMap> visibility_;     // of all layers; empty for one far layer
  std::vector<SourceMap> sources_;            // of the colours
  std::vector<Plane<uint8_t>> neighbours_;
  std::vector<Gain> gains_;  // of the photos
};

}  // namespace

BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job) {
  return build(frames, options, job, PoseEstimator(options.poses));
}

BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job, PoseEstimator begun) {
  check(options);
  if (begun.options() != options.poses) begun = PoseEstimator(options.poses);
  return Build(frames, options, job, std::move(begun)).run();
}

}  // namespace ldp
