#include "core/pipeline/crop.h"

#include <algorithm>

#include "core/arc/arc.h"
#include "core/pipeline/pipeline_tuning.h"

namespace ldp {
namespace {

using namespace pipeline;  // tuned constants

class Trimmer {
 public:
  explicit Trimmer(const std::vector<DisparityMap>& layers)
      : layers_(layers), box_{0, 0, layers[0].width, layers[0].height} {}

  // First what is empty, so that shares are those of a box that is seen to its sides.
  Window run(bool wraps) {
    const Window all = box_;
    for (const int least_seen : {0, kLeastSeen}) {
      least_seen_ = least_seen;
      while (box_.width > 0 && box_.height > 0 && (trim_rows() || (!wraps && trim_columns()))) {
      }
    }
    return box_.width > 0 && box_.height > 0 ? box_ : all;
  }

 private:
  bool trim_rows() {
    if (hardly_seen({box_.x, box_.y, box_.width, 1}))
      ++box_.y;
    else if (!hardly_seen({box_.x, box_.y + box_.height - 1, box_.width, 1}))
      return false;
    --box_.height;
    return true;
  }

  bool trim_columns() {
    if (hardly_seen({box_.x, box_.y, 1, box_.height}))
      ++box_.x;
    else if (!hardly_seen({box_.x + box_.width - 1, box_.y, 1, box_.height}))
      return false;
    --box_.width;
    return true;
  }

  bool hardly_seen(const Window& part) const {
    int seen = 0;
    for (int y = part.y; y < part.y + part.height; ++y)
      for (int x = part.x; x < part.x + part.width; ++x)
        seen += std::any_of(layers_.begin(), layers_.end(),
                            [&](const DisparityMap& layer) { return layer.at(x, y) != kNoDisparity; });
    return least_seen_ == 0 ? seen == 0 : seen * least_seen_ < part.width * part.height;
  }

  const std::vector<DisparityMap>& layers_;
  Window box_;
  int least_seen_ = 0;  // shares less than one by this are hardly any; 0: none is
};

bool is_all(const Window& box, int width, int height) { return box.width == width && box.height == height; }

template <typename T>
void crop(const Window& box, std::vector<Plane<T>>& planes) {
  for (Plane<T>& plane : planes) {
    Plane<T> part(box.width, box.height);
    for (int y = 0; y < box.height; ++y) std::copy_n(plane.row(box.y + y) + box.x, box.width, part.row(y));
    plane = std::move(part);
  }
}

}  // namespace

Window seen_box(const std::vector<DisparityMap>& layers, bool wraps) { return Trimmer(layers).run(wraps); }

PanoramaGrid crop_to_seen(const PanoramaGrid& grid, FoundLayers found) {
  const Window box = seen_box(found.disparities, grid.wraps);
  if (is_all(box, grid.width, grid.height)) return grid;
  crop(box, found.disparities);
  crop(box, found.neighbours);
  for (SourceMap& source : found.sources) source = source.part(box.x, box.y, box.width, box.height);
  return part_of(grid, box.x, box.y, box.width, box.height);
}

}  // namespace ldp
