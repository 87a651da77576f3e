// Frames a camera path inside what a panorama shows, so that its views have no black borders.
//
// Takes the panorama, its renderer and a path; looks at a few small views along it and gives the path turned to the
// middle of what is seen, closer and, where that is not enough, shorter, so that holes are some tenths of a per cent of
// the worst of them. A field of view that was asked for is kept: then only the way gets shorter. A path out of its
// ranges is refused (check_camera_path()).
#pragma once

#include "core/base/job.h"
#include "core/view/camera_path.h"
#include "core/view/render.h"

namespace ldp {

CameraPathOptions framed_inside(const LayeredPanorama& panorama, const Renderer& renderer, CameraPathOptions path,
                                const Job& job = {});

}  // namespace ldp
