#include "core/poses/poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/poses/coverage.h"
#include "core/poses/features/features.h"
#include "core/poses/pose_doubt.h"
#include "core/poses/poses_tuning.h"
#include "core/poses/reconstruct.h"
#include "core/poses/start/rotation_averaging.h"
#include "core/poses/tracks/geometric_verification.h"
#include "core/poses/unfit_frames.h"

namespace ldp {

using namespace sfm;

namespace {

// Mean square of the differences of neighbours.
double sharpness(const GreyImage& grey) {
  double sum = 0;
  for (int y = 1; y < grey.height; ++y) {
    for (int x = 1; x < grey.width; ++x) {
      const double right = grey.at(x, y) - grey.at(x - 1, y), down = grey.at(x, y) - grey.at(x, y - 1);
      sum += right * right + down * down;
    }
  }
  return sum / (static_cast<double>(grey.width) * grey.height);
}

Frame make_frame(const std::string& name, const RgbImage& image, std::optional<double> focal_hint) {
  Frame frame;
  frame.name = name;
  frame.focal_hint = focal_hint;
  frame.picture = make_grey_photo(image, kWorkingSide_px);
  frame.sharpness = sharpness(frame.picture.grey);
  frame.features = detect_features(frame.picture, FeatureOptions{});
  return frame;
}

TwoViewOptions two_view_options(const PosesOptions& options) {
  TwoViewOptions pairs;
  pairs.seed = options.seed;
  return pairs;
}

// From what is told of the frames that are of that size.
std::optional<FocalPrior> focal_prior(const std::vector<Frame>& frames, const PosesOptions& options) {
  const auto [width, height] = common_size(frames);
  if (options.fov_rad) return FocalPrior{0.5 * width / std::tan(0.5 * *options.fov_rad), kFovLogSigma};
  std::vector<double> hints;
  for (const Frame& frame : frames) {
    const bool common = frame.features.width == width && frame.features.height == height;
    if (common && frame.focal_hint) hints.push_back(*frame.focal_hint);
  }
  if (hints.empty()) return std::nullopt;
  std::nth_element(hints.begin(), hints.begin() + static_cast<std::ptrdiff_t>(hints.size() / 2), hints.end());
  return FocalPrior{hints[hints.size() / 2] * std::max(width, height), kExifLogSigma};
}

// World z up: perpendicular to the cameras' right axes, as far as they agree, and to where they look on the whole.
Eigen::Matrix3d upright(const std::vector<Pose>& cameras) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), forward = Eigen::Vector3d::Zero();
  for (const Pose& pose : cameras) up -= pose.world_from_camera.col(1), forward += pose.world_from_camera.col(2);
  up.normalize();
  Eigen::Vector3d y = forward - forward.dot(up) * up;
  if (y.norm() < 1e-6 * static_cast<double>(cameras.size())) y = up.unitOrthogonal();
  y.normalize();
  Eigen::Matrix3d rotation;
  rotation << y.cross(up).transpose(), y.transpose(), up.transpose();
  return rotation;
}

// Slope of centres against forward axes: the radius of a circle whose cameras look outward.
double circle_radius(const std::vector<Pose>& cameras) {
  Eigen::Vector3d c = Eigen::Vector3d::Zero(), f = c;
  const double count = static_cast<double>(cameras.size());
  for (const Pose& pose : cameras) c += pose.centre / count, f += pose.world_from_camera.col(2) / count;
  double above = 0, below = 0;
  for (const Pose& pose : cameras) {
    above += (pose.centre - c).dot(pose.world_from_camera.col(2) - f);
    below += (pose.world_from_camera.col(2) - f).squaredNorm();
  }
  return below > 1e-9 && above > 0.1 * below ? above / below : 1;
}

double path_length(const std::vector<Pose>& cameras) {
  double sum = 0;
  for (size_t i = 1; i < cameras.size(); ++i) sum += (cameras[i].centre - cameras[i - 1].centre).norm();
  return std::max(sum, 1e-9);
}

void check(const PosesOptions& options) {
  if (options.fov_rad && !(*options.fov_rad > 0.02 && *options.fov_rad < 3.1)) {
    throw std::logic_error("fov_rad must lie between 0.02 and 3.1, got " + std::to_string(*options.fov_rad));
  }
  if (!(options.arm_length > 0))
    throw std::logic_error("arm_length must be positive, got " + std::to_string(options.arm_length));
}

// Frames fit for it as a sweep, and which frame each of the sweep is.
struct SelectedSweep {
  MatchedSweep sweep;
  std::vector<int> frame;
};

SelectedSweep select_sweep(const std::vector<Frame>& frames, const std::vector<PairMatches>& pairs,
                           const std::vector<LeftOut>& unfit) {
  SelectedSweep selected;
  std::vector<int> place(frames.size(), -1);
  for (size_t i = 0; i < frames.size(); ++i) {
    if (unfit[i]) {
      ++selected.sweep.unfit;
      if (!selected.sweep.first_unfit && unfit[i].cause != LeftOutCause::needless) {
        selected.sweep.first_unfit_name = frames[i].name;
        selected.sweep.first_unfit = unfit[i];
      }
      continue;
    }
    place[i] = selected.sweep.frames();
    selected.sweep.pictures.push_back(frames[i].picture);
    selected.sweep.features.push_back(frames[i].features);
    selected.frame.push_back(static_cast<int>(i));
  }
  for (const PairMatches& pair : pairs) {
    const int a = place[static_cast<size_t>(pair.a)], b = place[static_cast<size_t>(pair.b)];
    if (a >= 0 && b >= 0 && !pair.matches.empty()) selected.sweep.pairs.push_back({a, b, pair.matches});
  }
  return selected;
}

std::vector<FrameReport> first_reports(const std::vector<Frame>& frames, const std::vector<PairMatches>& pairs,
                                       const std::vector<LeftOut>& unfit) {
  std::vector<FrameReport> reports;
  for (size_t i = 0; i < frames.size(); ++i) {
    FrameReport report;
    report.name = frames[i].name;
    report.features = frames[i].features.size();
    report.left_out = unfit[i];
    reports.push_back(report);
  }
  for (const PairMatches& pair : pairs) {
    if (unfit[static_cast<size_t>(pair.a)] || unfit[static_cast<size_t>(pair.b)]) continue;
    reports[static_cast<size_t>(pair.a)].matches += static_cast<int>(pair.matches.size());
    reports[static_cast<size_t>(pair.b)].matches += static_cast<int>(pair.matches.size());
  }
  return reports;
}

// Squares of the reprojection errors, summed by frame and over all.
void report_errors(const Bundle& bundle, const std::vector<int>& frame, PosesReport& report) {
  double all = 0;
  for (const BundleObservation& o : bundle.observations) {
    const Projection p = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens,
                                       bundle.points[static_cast<size_t>(o.point)]);
    const double squared = (p.position_px - o.position_px).squaredNorm();
    FrameReport& of_frame = report.frames[static_cast<size_t>(frame[static_cast<size_t>(o.camera)])];
    of_frame.reprojection_px += squared;
    ++of_frame.inliers;
    all += squared;
  }
  for (FrameReport& f : report.frames) f.reprojection_px = std::sqrt(f.reprojection_px / std::max(f.inliers, 1));
  report.reprojection_px = std::sqrt(all / static_cast<double>(std::max<size_t>(1, bundle.observations.size())));
}

Poses to_world(const Reconstruction& found, const SelectedSweep& selected, const std::vector<Frame>& frames,
               double arm_length) {
  const Bundle& bundle = found.bundle;
  std::vector<Pose> posed;
  Poses poses;
  std::vector<int> camera(bundle.cameras.size(), -1);
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    if (found.left_out[i]) continue;
    camera[i] = static_cast<int>(posed.size());
    posed.push_back(bundle.cameras[i]);
    poses.frame_of_camera.push_back(selected.frame[i]);
  }
  const Eigen::Matrix3d turn = upright(posed);
  const double scale =
      arm_length / (found.motion == Motion::straight ? 0.5 * path_length(posed) : circle_radius(posed));
  const Features& first = selected.sweep.features.front();
  Intrinsics k{first.width,          first.height,      bundle.lens.focal_px,
               bundle.lens.focal_px, 0.5 * first.width, 0.5 * first.height};
  k.k1 = bundle.lens.k1, k.k2 = bundle.lens.k2;
  for (size_t i = 0; i < posed.size(); ++i) {
    const Pose pose{turn * posed[i].world_from_camera, scale * turn * posed[i].centre};
    poses.cameras.push_back({frames[static_cast<size_t>(poses.frame_of_camera[i])].name, k, pose});
  }
  for (size_t i = 0; i < found.tracks.size(); ++i) {
    const InversePoint& point = bundle.points[i];
    ScenePoint scene{scale * turn * point.direction / std::max(point.inverse_distance, 1 / kMaxPointDistance), {}};
    std::vector<Eigen::Vector2d> sightings;
    for (const Observation& o : found.tracks[i]) {
      scene.cameras.push_back(camera[static_cast<size_t>(o.frame)]);
      sightings.emplace_back(o.position_px + Eigen::Vector2d(k.cx, k.cy));
    }
    poses.points.push_back(std::move(scene));
    poses.sightings.push_back(std::move(sightings));
  }
  return poses;
}

// A sweep's reconstruction and what speaks for and against it, by the pairs that it kept.
struct Judged {
  Reconstruction found;
  Doubt doubted;
  Coverage covered;
  double agreed = 1;

  ptrdiff_t lost() const {
    return std::count_if(found.left_out.begin(), found.left_out.end(), [](const LeftOut& why) { return bool(why); });
  }
  bool loses_most() const { return 2 * lost() >= static_cast<ptrdiff_t>(found.left_out.size()); }
  bool is_doubted() const { return doubted.kind != PoseDoubt::none; }
  bool may_be_wrong() const { return is_doubted() || covered.share() < kMinCoveredShare; }
  // Its points are spread over so many times as much of the photos.
  bool covers_more(double times, const Judged& than) const {
    return covered.explained > times * than.covered.explained;
  }
};

// Another reconstruction takes the first one's place if it is possible and better; whether it did.
bool replace_by_better(const std::function<Judged()>& reconstruct_otherwise,
                       const std::function<bool(const Judged&)>& is_better, Judged& first) {
  try {
    Judged second = reconstruct_otherwise();
    if (!is_better(second)) return false;
    first = std::move(second);
    return true;
  } catch (const Impossible&) {
    return false;
  }
}

// A wide lens that bends strongly passes for a narrow one that does not, on a sweep that turns less. So where a narrow
// one was found, a wide one is tried.
FocalPrior wide_lens(const MatchedSweep& sweep) {
  return {kWideFocal * std::max(sweep.features[0].width, sweep.features[0].height), kWideFocalLogSigma, true};
}

bool is_of_another_lens(double told_focal) { return std::abs(told_focal - 1) > kMaxToldFocalError; }

// A sweep's reconstructions, one after the other, by what is held to be known of its lens and how its tracks are
// chosen.
class Reconstructions {
 public:
  Reconstructions(MatchedSweep& sweep, std::vector<std::string> names, const std::optional<FocalPrior>& told,
                  const Job& job)
      : sweep_(sweep), verified_(sweep.pairs), names_(std::move(names)), told_(told), again_(job) {
    again_.progress = {};  // it has been told so far already
  }

  Judged best(const Job& job) {
    Judged judged = told_ ? as_told(job) : freely(job);
    if (lens_) try_without_what_was_told(judged);
    // What is tracked the longest decides where cameras start, and what keeps pace with them is tracked the longest. So
    // where they may be wrong, tracks spread over the photos are tried.
    if (judged.may_be_wrong()) {
      sweep_.track_grid = kSpreadTrackGrid;
      const auto covers_more = [&](const Judged& second) { return second.covers_more(kMinCoverageGain, judged); };
      replace_by_better([&] { return with_lens(again_); }, covers_more, judged);
    }
    return judged;
  }

  // How many times the focal length found was told; 1 where one of another lens was kept to.
  double told_focal(const Judged& best) const {
    const double ratio = ratio_told(best);
    return lens_ && is_of_another_lens(ratio) ? 1 : ratio;
  }

 private:
  double ratio_told(const Judged& judged) const {
    return told_ ? told_->focal_px / judged.found.bundle.lens.focal_px : 1;
  }

  Judged with_lens(const Job& job) {
    sweep_.pairs = verified_;
    Judged judged{reconstruct(sweep_, lens_, job), {}, {}};
    judged.doubted = doubt(sweep_, judged.found, names_, lens_ && !lens_->is_guess);
    judged.covered = coverage(sweep_, judged.found);
    judged.agreed = agreement(sweep_, judged.found);
    return judged;
  }

  // Where nothing comes of what was told of the lens, that may be why: then most photos are posed without.
  Judged as_told(const Job& job) {
    lens_ = told_;
    try {
      return with_lens(job);
    } catch (const Impossible&) {
      try {
        Judged judged = freely(again_);
        if (!judged.loses_most()) return judged;
      } catch (const Impossible&) {
      }
      throw;
    }
  }

  // Whatever was told of the lens.
  Judged freely(const Job& job) {
    lens_.reset();
    Judged judged = with_lens(job);
    if (view_of_longer_side(sweep_, judged.found.bundle.lens.focal_px) > kNarrowView_rad) return judged;
    lens_ = wide_lens(sweep_);
    const auto covers_more = [&](const Judged& second) { return second.covers_more(kMinLensGain, judged); };
    replace_by_better([&] { return with_lens(again_); }, covers_more, judged);
    lens_.reset();
    return judged;
  }

  // Where another lens was found, what was told pulls at the cameras; where photos are lost or poses doubted, it may be
  // why. Then they are found anew, and stay unless they are doubtful where the first ones were not, or their points are
  // spread over less of the photos, or, where the lens is as told, over hardly more.
  void try_without_what_was_told(Judged& first) {
    const bool is_another = is_of_another_lens(ratio_told(first));
    if (!is_another && !first.may_be_wrong() && first.lost() == 0) return;
    const auto is_better = [&](const Judged& second) {
      if (second.is_doubted() && !first.is_doubted()) return false;
      return is_another ? !first.covers_more(kMinLensGain, second) : second.covers_more(kMinLensGain, first);
    };
    if (!replace_by_better([&] { return freely(again_); }, is_better, first)) lens_ = told_;
  }

  MatchedSweep& sweep_;
  const std::vector<PairMatches> verified_;
  const std::vector<std::string> names_;
  const std::optional<FocalPrior> told_;
  Job again_;
  std::optional<FocalPrior> lens_;  // that is held to
};

Poses solve(const std::vector<Frame>& frames, const std::vector<PairMatches>& pairs, const std::vector<LeftOut>& unfit,
            const PosesOptions& options, const Job& job) {
  SelectedSweep selected = select_sweep(frames, pairs, unfit);
  std::vector<std::string> names;
  for (const int i : selected.frame) names.push_back(frames[static_cast<size_t>(i)].name);
  Reconstructions reconstructions(selected.sweep, std::move(names), focal_prior(frames, options), job);
  const Judged judged = reconstructions.best(job);
  const Reconstruction& found = judged.found;
  Poses poses = to_world(found, selected, frames, options.arm_length);
  poses.report.motion = found.motion;
  poses.report.closed = found.closed;
  poses.report.points = static_cast<int>(poses.points.size());
  poses.report.frames = first_reports(frames, pairs, unfit);
  for (size_t i = 0; i < selected.frame.size(); ++i) {
    FrameReport& report = poses.report.frames[static_cast<size_t>(selected.frame[i])];
    report.posed = !found.left_out[i];
    report.left_out = found.left_out[i];
  }
  poses.report.told_focal = reconstructions.told_focal(judged);
  poses.report.told_by_exif = !options.fov_rad;
  report_errors(found.bundle, selected.frame, poses.report);
  poses.report.doubt_kind = judged.doubted.kind;
  poses.report.doubt = judged.doubted.text;
  poses.report.agreement = judged.agreed;
  job.report("poses", 1);
  return poses;
}

std::string one_digit(double value) {
  const long tenths = std::lround(10 * value);
  return std::to_string(tenths / 10) + '.' + std::to_string(tenths % 10);
}

void require_three(int frames) {
  if (frames < 3) throw Impossible("at least 3 photos are needed, got " + std::to_string(frames));
}

bool begins_with(const FrameSource& source, int count, const std::vector<Frame>& frames) {
  if (static_cast<size_t>(count) < frames.size()) return false;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (source.name(static_cast<int>(i)) != frames[i].name) return false;
  }
  return true;
}

}  // namespace

std::string wrong_lens(const Poses& poses) {
  const double ratio = poses.report.told_focal;
  if (!is_of_another_lens(ratio)) return {};
  if (poses.report.told_by_exif)
    return "EXIF tells a focal length of " + one_digit(ratio) +
           " times what the photos show: they were cropped, or another program wrote it; what they show was taken";
  const Intrinsics& lens = poses.cameras.front().intrinsics;
  const double view_deg = 2 * std::atan(0.5 * lens.width / lens.fx) * 180 / std::numbers::pi;
  return "the photos show a field of view of " + one_digit(view_deg) +
         " degrees, which was taken instead of the one given: correct it";
}

struct PoseEstimator::State {
  PosesOptions options;
  std::vector<Frame> frames;
  FramePairs pairs;
  std::vector<LeftOut> unfit = {};  // by frame
};

PoseEstimator::PoseEstimator(const PosesOptions& options)
    : state_(new State{options, {}, FramePairs(two_view_options(options))}) {
  check(options);
}
PoseEstimator::PoseEstimator(PoseEstimator&&) noexcept = default;
PoseEstimator& PoseEstimator::operator=(PoseEstimator&&) noexcept = default;
PoseEstimator::~PoseEstimator() = default;

int PoseEstimator::size() const { return static_cast<int>(state_->frames.size()); }

const PosesOptions& PoseEstimator::options() const { return state_->options; }

void PoseEstimator::add_frames(const FrameSource& source, int count, const Job& job) {
  if (!begins_with(source, count, state_->frames)) *this = PoseEstimator(options());
  std::vector<Frame>& frames = state_->frames;
  const int first = size();
  frames.resize(static_cast<size_t>(count));
  job.report("features", 0);
  parallel_for(job, count - first, [&](int i) {
    const int index = first + i;
    frames[static_cast<size_t>(index)] = make_frame(source.name(index), source.load(index), source.focal_hint(index));
  });
  job.report("matching", 0.4);
  state_->unfit = unfit_frames(frames, state_->pairs, job);
  state_->pairs.match_all(frames, state_->unfit, job);
}

Poses PoseEstimator::finish(const Job& job) const {
  require_three(size());
  require_three_fit(state_->frames, state_->unfit);
  job.report("adjusting", 0.6);
  return solve(state_->frames, state_->pairs.all(), state_->unfit, options(), job);
}

Poses estimate_poses(const FrameSource& frames, PoseEstimator begun, const Job& job) {
  require_three(frames.size());
  begun.add_frames(frames, frames.size(), job);
  return begun.finish(job);
}

Poses estimate_poses(const FrameSource& frames, const PosesOptions& options, const Job& job) {
  return estimate_poses(frames, PoseEstimator(options), job);
}

}  // namespace ldp
