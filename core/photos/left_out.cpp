#include "core/photos/left_out.h"

namespace ldp {
std::string words_of(const LeftOut& why) {
  switch (why.cause) {
    case LeftOutCause::none:
      return {};
    case LeftOutCause::other_size:
      return "its size is not that of most photos (turned, cropped or scaled?)";
    case LeftOutCause::repeated:
      return "it is the same picture as " + why.original;
    case LeftOutCause::needless:
      return "it shows next to nothing that " + why.original + " does not";
    case LeftOutCause::without_texture:
      return "it shows next to no texture";
    case LeftOutCause::unmatched:
      return "it matches no other photo";
    case LeftOutCause::matched_elsewhere:
      return "it matches only photos that do not connect with the rest";
    case LeftOutCause::few_inliers:
      return "only " + std::to_string(why.inliers) + " of its points agree with the other photos";
    case LeftOutCause::few_shared_points:
      return "it shares too few points with the other photos";
    case LeftOutCause::up_or_down:
      return "it looks straight up or down";
    case LeftOutCause::no_camera:
      return "no camera of its name and size was given";
  }
  return {};
}

}  // namespace ldp
