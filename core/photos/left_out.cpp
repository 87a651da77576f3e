#include "core/photos/left_out.h"

namespace ldp {
namespace {

std::string pixels(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

}  // namespace

std::string words_of(const LeftOut& why) {
  switch (why.cause) {
    case LeftOutCause::none:
      return {};
    case LeftOutCause::other_size:
      return "it has " + pixels(why.size) + " pixels, the other photos " + pixels(why.common_size);
    case LeftOutCause::repeated:
      return "it is the same picture as " + why.original;
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
    case LeftOutCause::no_camera:
      return "no camera was given for it";
  }
  return {};
}

}  // namespace ldp
