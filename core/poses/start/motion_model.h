// What kind of motion a reconstruction shows: an arc, a straight path, or a rotation on the spot; and whether it
// closes.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/photos/left_out.h"
#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

// Does a camera that only rotates explain what is seen? Asked of the longest tracks, with cameras and lens adjusted for
// that model; `bundle` is then that solution, all points at infinity and all centres on the sphere, else as it was.
bool is_pure_rotation(const MatchedSweep& sweep, const std::vector<Track>& tracks, Bundle& bundle, const Job& job);

// Was the arc made of what a shaking hand moves against near things? Then a camera that only rotates, of another focal
// length, explains nearly all of it: the more the focal lengths differ, the less it has to. It has the arc's
// distortion: with one of its own it could bend a short arc's parallax straight. Asked of tracks by KLT, which are
// truer than matches, and of an arc that was refined; if so `bundle` becomes the rotation, as above.
bool is_false_arc(const MatchedSweep& sweep, const std::vector<Track>& tracks, Bundle& bundle, const Job& job);

// Puts cameras that go round an arc where the sphere of spherical_motion.h has them: the circle's centre at the origin,
// its radius 1. False, and nothing changed, when they do not go round one.
bool normalise_to_sphere(const std::vector<LeftOut>& left_out, Bundle& bundle);

// Mean distance of the cameras' steps from those that their turns would make on the sphere, in radii, apart from what
// all steps share.
double motion_roughness(const std::vector<LeftOut>& left_out, const Bundle& bundle);

// Arc or straight, and closed.
void classify_motion(const MatchedSweep& sweep, Reconstruction& reconstruction);

}  // namespace ldp::sfm
