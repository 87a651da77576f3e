// What structure from motion tells of a sweep's quality.
#pragma once

#include "core/poses/poses.h"
#include "core/verdict/evidence.h"

namespace ldp {

// `photos_taken`: posed or not; those that show what others show are not counted. `evidence.photos` stand for the
// cameras.
void add_pose_evidence(const Poses& poses, int photos_taken, SweepEvidence& evidence);

}  // namespace ldp
