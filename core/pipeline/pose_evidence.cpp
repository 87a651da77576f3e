#include "core/pipeline/pose_evidence.h"

#include <algorithm>

#include "core/verdict/track_flow.h"

namespace ldp {
namespace {

SweepMotion motion_from(Motion motion) {
  if (motion == Motion::rotation) return SweepMotion::rotation;
  return motion == Motion::straight ? SweepMotion::straight : SweepMotion::arc;
}

DoubtfulPoses doubtful(PoseDoubt kind) {
  switch (kind) {
    case PoseDoubt::none:
      return DoubtfulPoses::no;
    case PoseDoubt::contradicted:
    case PoseDoubt::unrelated:
      return DoubtfulPoses::contradicted;
    case PoseDoubt::loose:
    case PoseDoubt::in_pairs:
      return DoubtfulPoses::loose;
    case PoseDoubt::lens:
      return DoubtfulPoses::lens;
  }
  return DoubtfulPoses::no;
}

int shown_by_others(const PosesReport& report) {
  return static_cast<int>(std::count_if(report.frames.begin(), report.frames.end(),
                                        [](const FrameReport& frame) { return frame.left_out.is_shown_by_another(); }));
}

}  // namespace

void add_pose_evidence(const Poses& poses, int photos_taken, SweepEvidence& evidence) {
  evidence.motion = motion_from(poses.report.motion);
  evidence.doubt = doubtful(poses.report.doubt_kind);
  evidence.photos_taken = photos_taken - shown_by_others(poses.report);
  const Intrinsics& k = poses.cameras.front().intrinsics;
  evidence.reprojection = poses.report.reprojection_px / std::max(k.width, k.height);
  evidence.agreement = poses.report.agreement;
  measure_flow(poses.points, poses.sightings, poses.cameras, evidence);
}

}  // namespace ldp
