#include "core/pipeline/build.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/arc/arc.h"
#include "core/base/exact_math.h"
#include "core/base/memory/large_arrays.h"
#include "core/colour/colour.h"
#include "core/colour/halved_candidates.h"
#include "core/consistency/back_projection.h"
#include "core/consistency/consistency.h"
#include "core/layers/layers.h"
#include "core/layers/proposal_fusion.h"
#include "core/layers/simpler_maps.h"
#include "core/photos/exposure/local_exposure.h"
#include "core/pipeline/code_layers.h"
#include "core/pipeline/crop.h"
#include "core/pipeline/debug_pictures.h"
#include "core/pipeline/grid_layout.h"
#include "core/pipeline/pipeline_tuning.h"
#include "core/pipeline/pose_evidence.h"
#include "core/pipeline/seen_part.h"
#include "core/pipeline/stage_order.h"
#include "core/pipeline/stopwatch.h"
#include "core/rectify/rectify.h"
#include "core/sweep/cost_volume.h"
#include "core/verdict/colour_quality.h"
#include "core/verdict/judge.h"
#include "core/verdict/measured_frames.h"
#include "core/verdict/rephotography.h"
#include "core/verdict/words.h"

namespace ldp {
namespace {

using namespace pipeline;  // tuned constants

void require(bool sound, const std::string& field, int value, const std::string& bounds) {
  if (!sound) throw std::logic_error("BuildOptions: " + field + " is " + std::to_string(value) + ", must be " + bounds);
}

void check(const BuildOptions& options) {
  require(options.layers >= 1 && options.layers <= 8, "layers", options.layers, "1 .. 8");
  require(options.labels >= 2 && options.labels <= kLabels, "labels", options.labels, "2 .. 16");
  require(options.iterations >= 0 && options.iterations <= 4, "iterations", options.iterations, "0 .. 4");
  require(options.block_px >= 0, "block_px", options.block_px, "0 or more");
}

// What a build knows so far. Disparity maps stand for layers until their colours are fetched.
class Build {
 public:
  Build(const FrameSource& frames, const BuildOptions& options, const Job& job, PoseEstimator begun, Poses found = {})
      : frames_(frames),
        options_(options),
        effort_(options_of(options.effort)),
        job_(job),
        watch_(report_.seconds, report_.processor_seconds),
        pictures_(options.debug_directory),
        begun_(std::move(begun)),
        poses_(std::move(found)) {}

  BuildResult run() { return run_in_order(*this, options_.layers, iterations_of(options_)); }

 private:
  template <typename Stages>
  friend auto ldp::run_in_order(Stages& stages, int layers, int iterations);
  template <typename Stages>
  friend void ldp::find_layers_in_order(Stages& stages, int layers, int iterations);

  void find_cameras() {
    if (poses_.cameras.empty())
      poses_ = options_.cameras.empty() ? estimate_poses(frames_, std::move(begun_), job_)
                                        : triangulate(frames_, options_.cameras, options_.poses, job_);
    if (!poses_.report.doubt.empty()) report_.notes.push_back("the poses may be wrong: " + poses_.report.doubt);
    if (const std::string what = wrong_lens(poses_); !what.empty()) report_.notes.push_back(what);
    watch_.lap("poses");
  }

  void lay_out() {
    report_.arc = fit_arc(poses_.cameras);
    while (leave_out_up_or_down()) report_.arc = fit_arc(poses_.cameras);
    const bool given = !options_.cameras.empty();  // triangulate tells only whether they turned on the spot
    if (given && parallax() && report_.arc.straight && !nods(poses_.cameras)) poses_.report.motion = Motion::straight;
    if (const std::string what = sideways(poses_.cameras); !what.empty()) report_.notes.push_back(what);
    layout_ = std::make_unique<GridLayout>(poses_, report_.arc, options_, report_.notes);
    watch_.lap("arc");
    const MeasuredFrames measured(frames_);
    upright_ = rectify(measured, poses_.cameras, poses_.frame_of_camera, poses_.points, report_.arc.arc,
                       layout_->pitch_px(), job_, &calibration_);
    collect_gains();
    watch_.lap("rectify");
    if (parallax()) layout_->take_in_what_is_nearer(upright_, job_);
    grid_ = layout_->grid();
    judge_sweep_so_far(measured);
    columns_of_colour_ = layout_->columns_of_colour();
    report_.laid = {grid_.width, grid_.height, columns_of_colour_,
                    upright_pixels(poses_.cameras, report_.arc.arc, layout_->pitch_px())};
    watch_.lap("depth range");
    if (parallax()) leave_out_unseen();
  }

  // Photos taken while the arm was lowered; whether there were any. Where most are like that it is another mistake,
  // which rectification names.
  bool leave_out_up_or_down() {
    std::vector<LeftOut> why(poses_.cameras.size());
    size_t count = 0;
    for (size_t i = 0; i < why.size(); ++i) {
      if (!looks_straight_up_or_down(poses_.cameras[i], report_.arc.arc)) continue;
      why[i].cause = LeftOutCause::up_or_down;
      ++count;
    }
    if (count == 0 || why.size() - count < std::max(kFewestLevel, count)) return false;
    leave_out(why, poses_);
    return true;
  }

  // Who has to sweep again should hear it before the panorama is done.
  void judge_sweep_so_far(const MeasuredFrames& measured) {
    rephotography_.emplace(grid_, poses_.cameras, gains_, job_, report_.evidence);
    for (size_t i = 0; i < poses_.cameras.size(); ++i)
      report_.evidence.photos[i].measures = measured.of(poses_.frame_of_camera[i]);
    add_pose_evidence(poses_, frames_.size(), report_.evidence);
    const SweepQuality quality = judge_sweep(report_.evidence);
    if (quality.grade != Grade::good && job_.remark) job_.remark(text_of(quality));
  }

  // What no photograph sees is neither swept nor solved.
  void leave_out_unseen() {
    SeenPart part = find_seen_part(upright_, grid_, job_);
    grid_ = part_of(grid_, part.box.x, part.box.y, part.box.width, part.box.height);
    seen_ = std::move(part.mask);
    watch_.lap("seen part");
  }

  bool parallax() const { return has_parallax(poses_); }

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
    add_layer(grid_, farthest_around(grid_, layers_[0], kSilhouettePx), upright_, {}, job_, maps);
    watch_.lap("visibility");
    return maps;
  }

  DisparityMap front_layer(const std::string& name) {
    DisparityMap disparity = swept_front(name);
    if (!last_) return disparity;  // what only hides does so inside its outlines
    fit_outlines(grid_, upright_, job_, disparity);
    watch_.lap("outlines");
    fuse_proposals(disparity);
    watch_.lap("fusion");
    return disparity;
  }

  DisparityMap swept_front(const std::string& name) {
    const std::vector<VisibilityMap> hiding = sure_visibility();
    SweepOptions options = sweep_options();
    options.points = &poses_.points;
    const CostVolume sweep(upright_, grid_, hiding, DisparityMap(), options);
    std::optional<CheapestLabels> cheapest;
    if (last_) cheapest.emplace(sweep);
    const CostSource& costs = last_ ? static_cast<const CostSource&>(*cheapest) : sweep;
    const Plane<uint8_t> labels = solve(costs, seen_, name);
    DisparityMap disparity = refine(sweep, labels, seen_, job_);
    if (cheapest) unsmoothed_ = unsmoothed(sweep, *cheapest, labels);
    watch_.lap("refine");
    return disparity;
  }

  // What matches best by itself, where that is no chance.
  DisparityMap unsmoothed(const CostVolume& sweep, const CheapestLabels& costs, const Plane<uint8_t>& chosen) const {
    DisparityMap found = refine(sweep, costs.cheapest(), costs.clearly_nearer(chosen, kUnsmoothedPx), job_);
    drop_small_components(kUnsmoothedPx, grid_.wraps, found, gap_steps(grid_, {}));
    return found;
  }

  // The later of two iterations frees what stands beside near surfaces, and eats their edges where they are plain; each
  // is right in places. Then every pixel is offered the surfaces around it, and at last what is simpler.
  void fuse_proposals(DisparityMap& layer) {
    ProposalFusion fusion(grid_, upright_, effort_.columns_apart);
    if (!layers_.empty()) {
      DisparityMap before = std::move(layers_[0]);
      fit_outlines(grid_, upright_, job_, before);
      fusion.fuse(before, kIterationsReachPx, job_, layer);
    }
    fusion.fuse(over(std::exchange(unsmoothed_, {}), layer), kPropagationReachPx, job_, layer);
    offer_by_lightness(fusion, layer);
    const auto offer = [&](int right, int down) {
      fusion.fuse(shifted(grid_, layer, right, down), kPropagationReachPx, job_, layer);
    };
    for (const int px : effort_.upright_px)
      for (const int down : {px, -px}) offer(0, down);
    for (const int px : effort_.propagation_px)
      for (const auto& [right, down] : {std::pair(px, 0), {-px, 0}, {0, px}, {0, -px}}) offer(right, down);
    fusion.simplify(simpler_than(layer), kDoubtReachPx, job_, layer);
    absorb_specks(grid_, kFrontSpeckPx, layer);
  }

  // Specks would keep squares off their planes, and a plane may itself end in a step.
  DisparityMap simpler_than(const DisparityMap& layer) const {
    DisparityMap simpler = layer;
    absorb_specks(grid_, kDoubtfulPx, simpler);
    put_onto_planes(grid_, job_, simpler);
    close_plain_tears(grid_, upright_, job_, simpler);
    return simpler;
  }

  // What is lighter, or darker, than what is around it is offered the nearest and the farthest surface there: where a
  // wire breaks, and between leaves.
  void offer_by_lightness(ProposalFusion& fusion, DisparityMap& layer) const {
    const Plane<Lightness> alike = lightness(grid_, upright_, layer, kLightnessReachPx, job_);
    for (const Lightness kind : {Lightness::lighter, Lightness::darker})
      for (const auto around : {nearest_around, farthest_around}) {
        DisparityMap proposal = around(grid_, layer, kLightnessReachPx);
        for (size_t i = 0; i < proposal.samples.size(); ++i)
          if (alike.samples[i] != kind) proposal.samples[i] = layer.samples[i];
        fusion.fuse(proposal, kPropagationReachPx, job_, layer);
      }
  }

  // `front` where it is present.
  static DisparityMap over(DisparityMap front, const DisparityMap& layer) {
    for (size_t i = 0; i < front.samples.size(); ++i)
      if (front.samples[i] == kNoDisparity) front.samples[i] = layer.samples[i];
    return front;
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
    const DisparityMap likely = likely_behind(grid_, found[0], kBehindLikelyPx);
    const BoundaryCosts costs(sweep, want, surface, likely);
    const Plane<uint8_t> labels = solve(costs, want, name);
    DisparityMap layer = refine(sweep, labels, want, job_);
    const int gap = gap_steps(grid_, {});
    for (size_t i = 0; i < layer.samples.size(); ++i) {
      const bool behind = layer.samples[i] + gap <= surface.samples[i];
      if (want.samples[i] != kWanted || !behind) layer.samples[i] = kNoDisparity;
    }
    continue_background(want, surface, gap, layer);
    watch_.lap("refine");
    smooth_behind(grid_, surface, gap, kBehindMedianPx, job_, layer);
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
    sweep.substeps = last_ ? effort_.substeps : kHidingSubsteps;
    return sweep;
  }

  Plane<uint8_t> solve(const CostSource& costs, const Plane<uint8_t>& mask, const std::string& name) {
    SolveOptions solving;
    solving.iterations = last_ ? kIterations : kHidingIterations;
    solving.cycles = last_ ? effort_.cycles : kHidingCycles;
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
      solving.cycles = effort_.cycles;
      const HalvedCandidates halved(candidates);
      const ColourSolve solved = solve_colour(halved, solving, job_);
      SourceMap sources = halved.spread(solved.sources, job_);
      const std::string name = "colour layer " + std::to_string(k + 1);
      report_.solves.push_back({name, solved.report});
      pictures_.sources("sources layer " + std::to_string(k + 1), sources);
      drop_colourless(sources, layers_[k]);
      neighbours_.push_back(candidates.neighbours(sources, job_));
      sources_.push_back(std::move(sources));
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
    grid_ = crop_to_seen(grid_, {layers_, sources_, neighbours_});
    panorama.grid = grid_;
    panorama.cameras = poses_.cameras;
    panorama.limits = viewing_limits();
    panorama.layers = code_layers(grid_, columns_of_colour_, options_.block_px, layers_, sources_);
    panorama.exposure = local_exposure();
    fetch(panorama.exposure, panorama.layers);
    for (size_t k = 0; k < layers_.size(); ++k) {
      const auto present =
          std::count(panorama.layers[k].coverage.samples.begin(), panorama.layers[k].coverage.samples.end(), 1);
      report_.coverage.push_back(static_cast<double>(present) / static_cast<double>(layers_[k].samples.size()));
      pictures_.colour("colour layer " + std::to_string(k + 1), panorama.layers[k].colour);
    }
    hold_against_photographs(panorama);
    report_.poses = poses_.report;
    report_.quality = judge(report_.evidence);
    panorama.quality = figures_of(report_.quality);
    result.colour_quality = colour_quality_for(report_.quality.photos_back_psnr_db);
    watch_.lap("verdict");
    result.report = std::move(report_);
    result.scratch = layout_->give_scratch();
    return result;
  }

  void collect_gains() {
    for (const UprightFrame& frame : upright_) gains_.push_back(frame.gain);
    for (size_t i = 0; i < gains_.size(); ++i) report_.gains[poses_.cameras[i].name] = own_gains()[i];
  }

  // Empty where one exposure does for all.
  DisplayExposure local_exposure() const {
    if (!calibration_) return {};
    return {LocalExposure(poses_.cameras, calibration_->light_gains).over(grid_), calibration_->response};
  }

  // Of levels; of light where exposure is local.
  const std::vector<Gain>& own_gains() const { return calibration_ ? calibration_->light_gains : gains_; }

  void fetch(const DisplayExposure& local, std::vector<Layer>& layers) {
    const Photographs photographs{frames_, poses_.cameras, poses_.frame_of_camera, own_gains(), local};
    std::vector<UprightFrame>().swap(upright_);  // the colours need their memory
    std::vector<ColourTask> tasks;
    for (size_t k = 0; k < layers.size(); ++k)
      tasks.push_back({&layers_[k], &sources_[k], &layers[k].colour, &neighbours_[k]});
    blend_colours(grid_, photographs, tasks, {}, job_);
    watch_.lap("colour");
  }

  void hold_against_photographs(LayeredPanorama& panorama) {
    std::vector<SourceMap>().swap(sources_);
    std::vector<Plane<uint8_t>>().swap(neighbours_);
    std::vector<DisparityMap>().swap(layers_);
    AgreementSink sink;
    if (pictures_.wanted())
      sink = [&](const std::string& photo, const Plane<uint8_t>& map) {
        pictures_.agreement("agreement " + std::filesystem::path(photo).stem().string(), map);
      };
    BackProjection towards(panorama, job_);
    report_.consistency = hold_against({frames_, poses_.frame_of_camera, own_gains()}, panorama, {}, job_, sink,
                                       {&*rephotography_, &towards});
    towards.correct(panorama.layers.front());
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

  const RecycledArrays recycled_;
  const FrameSource& frames_;
  const BuildOptions& options_;
  const EffortOptions& effort_;
  const Job& job_;
  BuildReport report_;
  Stopwatch watch_;
  DebugPictures pictures_;
  PoseEstimator begun_;
  Poses poses_;
  std::unique_ptr<GridLayout> layout_;  // holds the scratch space of what follows
  PanoramaGrid grid_;
  int columns_of_colour_ = 1;  // to each of the columns in which depths are found
  std::vector<UprightFrame> upright_;
  Plane<uint8_t> seen_;      // the grid's part that some photo may see; empty: all of it
  bool last_ = true;         // is this the last iteration?
  DisparityMap unsmoothed_;  // in the last iteration, until it is fused; kNoDisparity where it tells nothing
  std::vector<DisparityMap> layers_, found_;  // of the last iteration that ended, of the present one
  std::vector<VisibilityMap> visibility_;     // of all layers; empty for one far layer
  std::vector<SourceMap> sources_;            // of the colours
  std::vector<Plane<uint8_t>> neighbours_;
  std::vector<Gain> gains_;                 // of the photos
  std::optional<Calibration> calibration_;  // of their light, where exposure is local
  std::optional<Rephotography> rephotography_;
};

}  // namespace

int iterations_of(const BuildOptions& options) {
  return options.iterations > 0 ? options.iterations : options_of(options.effort).iterations;
}

BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job) {
  return build(frames, options, job, PoseEstimator(options.poses));
}

BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job, PoseEstimator begun) {
  check(options);
  if (begun.options() != options.poses) begun = PoseEstimator(options.poses);
  return Build(frames, options, job, std::move(begun)).run();
}

BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job, Poses found) {
  check(options);
  return Build(frames, options, job, PoseEstimator(options.poses), std::move(found)).run();
}

}  // namespace ldp
