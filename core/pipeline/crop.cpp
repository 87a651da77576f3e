#include "core/pipeline/crop.h"

#include <algorithm>

#include "core/arc/arc.h"
#include "core/pipeline/pipeline_tuning.h"

namespace ldp {
namespace {

using namespace pipeline;  // tuned constants

// Counts what is present once, and then keeps count: looking again at a row for every column that goes would take the
// square of a panorama of which photographs see little.
class Trimmer {
 public:
  explicit Trimmer(const std::vector<DisparityMap>& layers)
      : layers_(layers), box_{0, 0, layers[0].width, layers[0].height} {
    rows_.resize(static_cast<size_t>(box_.height)), columns_.resize(static_cast<size_t>(box_.width));
    for (int y = 0; y < box_.height; ++y) {
      for (int x = 0; x < box_.width; ++x) {
        if (!present(x, y)) continue;
        ++rows_[static_cast<size_t>(y)], ++columns_[static_cast<size_t>(x)];
      }
    }
  }

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
  bool present(int x, int y) const {
    return std::any_of(layers_.begin(), layers_.end(),
                       [&](const DisparityMap& layer) { return layer.at(x, y) != kNoDisparity; });
  }

  bool trim_rows() {
    const int top = box_.y, bottom = box_.y + box_.height - 1;
    const bool from_top = hardly_seen(rows_[static_cast<size_t>(top)], box_.width);
    if (!from_top && !hardly_seen(rows_[static_cast<size_t>(bottom)], box_.width)) return false;
    const int y = from_top ? top : bottom;
    if (rows_[static_cast<size_t>(y)] > 0) {
      for (int x = box_.x; x < box_.x + box_.width; ++x) columns_[static_cast<size_t>(x)] -= present(x, y) ? 1 : 0;
    }
    box_.y += from_top ? 1 : 0;
    --box_.height;
    return true;
  }

  bool trim_columns() {
    const int left = box_.x, right = box_.x + box_.width - 1;
    const bool from_left = hardly_seen(columns_[static_cast<size_t>(left)], box_.height);
    if (!from_left && !hardly_seen(columns_[static_cast<size_t>(right)], box_.height)) return false;
    const int x = from_left ? left : right;
    if (columns_[static_cast<size_t>(x)] > 0) {
      for (int y = box_.y; y < box_.y + box_.height; ++y) rows_[static_cast<size_t>(y)] -= present(x, y) ? 1 : 0;
    }
    box_.x += from_left ? 1 : 0;
    --box_.width;
    return true;
  }

  bool hardly_seen(int seen, int pixels) const { return least_seen_ == 0 ? seen == 0 : seen * least_seen_ < pixels; }

  const std::vector<DisparityMap>& layers_;
  Window box_;
  std::vector<int> rows_, columns_;  // present in the box
  int least_seen_ = 0;               // shares less than one by this are hardly any; 0: none is
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
