// A panorama as it is seen all around from one place, or by two eyes that turn with the head: equirectangular.
//
// Rendered from the layers in slits of a few columns, each a perspective view (core/view). One eye: all rays leave from
// one place. Two eyes: omnidirectional stereo (concentric mosaics, Peleg et al. 2001): rays are tangents of a circle
// whose diameter is the distance of the eyes, so that every direction has its own pair of eyes.
#pragma once

#include <Eigen/Core>
#include <utility>

#include "core/base/job.h"
#include "core/export/equirectangular.h"
#include "core/panorama/panorama.h"
#include "core/view/render.h"

namespace ldp {

// In the arc's axes (u(middle of the sweep), u(90 degrees on), n) from its centre, the capture's unit.
struct Viewer {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  double eyes = 0.064;  // distance of the eyes; 0 .. arc.radius
};

// The band that the panorama shows, at its own resolution; what no photograph shows is continued background.
FlatPanorama see_around(const LayeredPanorama& panorama, const Renderer& renderer, const Eigen::Vector3d& at,
                        const Job& job = {});

// Left and right eye; the same size.
std::pair<FlatPanorama, FlatPanorama> see_around_in_stereo(const LayeredPanorama& panorama, const Renderer& renderer,
                                                           const Viewer& viewer, const Job& job = {});

// Both in whole spheres, the left eye's above the right one's, as players of stereo panoramas take them.
RgbImage top_bottom(const FlatPanorama& left, const FlatPanorama& right);

}  // namespace ldp
