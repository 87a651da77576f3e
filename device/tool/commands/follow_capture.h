// Poses of a capture that is still being taken: begun photo by photo, so that little is left to do at its end.
//
// Takes lines: the name of each photo once it is stored, and "end" once the capture is complete. Gives poses begun with
// those photos; what came in too late is left to the build. Throws Impossible when the lines end without "end",
// std::runtime_error at a name that no photo has.
#pragma once

#include "core/base/job.h"
#include "core/poses/poses.h"
#include "device/tool/build_setup.h"

namespace ldp {

PoseEstimator follow_capture(const BuildSetup& setup, int lines_fd, const Job& job);

}  // namespace ldp
