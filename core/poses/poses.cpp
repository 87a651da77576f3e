#include "poses.h"

namespace ldp {

Poses estimate_poses(const FrameSource&, const PosesOptions&, const Job&) {
  throw Impossible("poses cannot be estimated yet: give them with --cameras");
}

}  // namespace ldp
