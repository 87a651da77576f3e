#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <functional>
#include <utility>

#include "core/base/exact_math.h"
#include "core/consistency/classify.h"
#include "core/consistency/consistency.h"
#include "core/consistency/rendered_photos.h"

namespace ldp {
namespace {

using consistency::Classifier;
using consistency::grey;
using consistency::Held;
using consistency::kCellPx;
using consistency::Rendering;

// The parts of the panorama's width, told by the directions in which they end.
class Directions {
 public:
  Directions(const PanoramaGrid& grid, int count) : grid_(grid) {
    const double span = grid.theta_pitch * grid.width / count;
    for (int i = 0; i < count; ++i)
      report_.push_back({grid.theta_left - span * (i + 1), grid.theta_left - span * i, {}});
    for (const DirectionResiduals& d : report_) middles_.push_back(exact_sine_cosine((d.from + d.to) / 2));
  }

  // The part whose middle is nearest to a direction in the world.
  size_t nearest(const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d in_arc = exact_transposed_product(grid_.arc.world_from_arc, direction);
    size_t best = 0;
    for (size_t i = 1; i < middles_.size(); ++i)
      if (along(in_arc, i) > along(in_arc, best)) best = i;
    return best;
  }
  void add(size_t part, const ResidualStatistics& sums) { report_[part].statistics.add(sums); }
  const std::vector<DirectionResiduals>& report() const { return report_; }

 private:
  double along(const Eigen::Vector3d& in_arc, size_t i) const {
    return in_arc.x() * middles_[i].cosine + in_arc.y() * middles_[i].sine;
  }

  const PanoramaGrid& grid_;
  std::vector<DirectionResiduals> report_;
  std::vector<SineCosine> middles_;
};

// By which shift the rendering comes closest to the photograph where they agree (one step of Lucas and Kanade, 1981),
// and how much steeper one of them is.
void compare_sharpness(const RgbImage& photo, const RgbImage& view, const Plane<uint8_t>& map, PhotoResiduals& out) {
  int64_t xx = 0, xy = 0, yy = 0, xt = 0, yt = 0, steep_photo = 0, steep_view = 0;
  for (int y = 2; y + 2 < photo.height; y += 2)
    for (int x = 2; x + 2 < photo.width; x += 2) {
      if (map.at(x / 2, y / 2) != static_cast<uint8_t>(Agreement::agrees)) continue;
      const auto gradient = [&](const RgbImage& of) {
        return std::array{grey(of.at(x + 1, y)) - grey(of.at(x - 1, y)), grey(of.at(x, y + 1)) - grey(of.at(x, y - 1))};
      };
      const auto p = gradient(photo), v = gradient(view);
      const int64_t gx = p[0] + v[0], gy = p[1] + v[1], t = grey(view.at(x, y)) - grey(photo.at(x, y));
      xx += gx * gx, xy += gx * gy, yy += gy * gy, xt += gx * t, yt += gy * t;
      steep_photo += std::abs(p[0]) + std::abs(p[1]);
      steep_view += std::abs(v[0]) + std::abs(v[1]);
    }
  const double det =
      static_cast<double>(xx) * static_cast<double>(yy) - static_cast<double>(xy) * static_cast<double>(xy);
  if (det > 0) {  // gradients are sums of two differences over two pixels
    out.shift_x =
        4 * (static_cast<double>(yy) * static_cast<double>(xt) - static_cast<double>(xy) * static_cast<double>(yt)) /
        det;
    out.shift_y =
        4 * (static_cast<double>(xx) * static_cast<double>(yt) - static_cast<double>(xy) * static_cast<double>(xt)) /
        det;
  }
  if (steep_view > 0) out.sharpness = static_cast<double>(steep_photo) / static_cast<double>(steep_view);
}

class Holding {
 public:
  Holding(const Evidence& evidence, const LayeredPanorama& panorama, const ConsistencyOptions& options, const Job& job,
          const std::vector<consistency::Observer*>& observers)
      : panorama_(panorama),
        options_(options),
        job_(job),
        observers_(observers),
        renderings_(evidence, panorama),
        directions_(panorama.grid, options.directions) {}

  ConsistencyReport run(const AgreementSink& sink) {
    const size_t photos = panorama_.cameras.size();
    Job alone = job_;  // while the other threads compare
    alone.threads = 1;
    const auto prepare = [&](size_t index, const Job& job) {
      if (index < photos) renderings_.prepare(index, job);
    };
    prepare(0, job_);
    for (size_t next = 0; next <= photos; ++next) {  // is rendered; the one before it is compared
      job_.report("consistency", static_cast<double>(next) / static_cast<double>(photos + 1));
      if (next < photos) take(next);
      const auto meanwhile = [&] { prepare(next + 1, next > 0 ? alone : job_); };
      if (next > 0)
        compare(next - 1, sink, meanwhile);
      else
        meanwhile();
      if (held_.size() > 2) held_.pop_front();
    }
    report_.directions = directions_.report();
    return std::move(report_);
  }

 private:
  struct Taken {
    size_t index;
    Held held;
    Rendering rendering;
  };

  void take(size_t index) {
    consistency::RenderedPhoto taken = renderings_.take(job_);
    held_.push_back({index,
                     {&panorama_.cameras[index], std::move(taken.photo), std::move(taken.view.depth)},
                     {std::move(taken.view.colour), std::move(taken.view.alpha)}});
    const Held* before = index > 0 ? &held_[held_.size() - 2].held : nullptr;
    for (consistency::Observer* observer : observers_)
      observer->rendered(index, held_.back().held, held_.back().rendering, before);
  }

  void compare(size_t index, const AgreementSink& sink, const std::function<void()>& meanwhile) {
    const auto own = std::find_if(held_.begin(), held_.end(), [&](const Taken& t) { return t.index == index; });
    std::vector<const Held*> beside;
    for (const Taken& other : held_)
      if (other.index != index) beside.push_back(&other.held);
    const RgbImage& photo = own->held.photo;
    PhotoResiduals residuals;
    residuals.name = own->held.camera->name;
    residuals.noise = consistency::plain_noise(photo, own->rendering);
    const int tolerance = std::clamp(static_cast<int>(std::lround(options_.tolerance_noises * residuals.noise)),
                                     options_.least_tolerance, options_.most_tolerance);
    Plane<uint8_t> map((photo.width + 1) / 2, (photo.height + 1) / 2);
    const Classifier classifier(own->held, own->rendering, beside, most_inverse_z(), tolerance, options_.most_depths);
    const int across = (photo.width + kCellPx - 1) / kCellPx, down = (photo.height + kCellPx - 1) / kCellPx;
    std::vector<ResidualStatistics> cells(static_cast<size_t>(across * down));
    parallel_for(job_, 1 + across * down, [&](int task) {
      if (task == 0) return meanwhile();
      const int cell = task - 1;
      cells[static_cast<size_t>(cell)] = classifier.cell(cell % across * kCellPx, cell / across * kCellPx, map);
    });
    for (int cell = 0; cell < across * down; ++cell)
      add_cell(*own, cell % across, cell / across, cells[static_cast<size_t>(cell)], residuals);
    compare_sharpness(photo, own->rendering.colour, map, residuals);
    report_.all.add(residuals.statistics);
    report_.photos.push_back(std::move(residuals));
    own->rendering = {};
    if (sink) sink(own->held.camera->name, map);
  }

  void add_cell(const Taken& own, int column, int row, const ResidualStatistics& sums, PhotoResiduals& residuals) {
    residuals.statistics.add(sums);
    const Camera& camera = *own.held.camera;
    const Eigen::Vector2d middle((column + 0.5) * kCellPx, (row + 0.5) * kCellPx);
    const Eigen::Vector3d ray = exact_product(camera.pose.world_from_camera, unproject(camera.intrinsics, middle));
    directions_.add(directions_.nearest(ray), sums);
  }

  // Cameras stand a little nearer to things than the panorama's rays begin.
  double most_inverse_z() const { return 1.25 * std::max(panorama_.grid.w_near, 1e-9); }

  const LayeredPanorama& panorama_;
  const ConsistencyOptions& options_;
  const Job& job_;
  const std::vector<consistency::Observer*>& observers_;
  consistency::RenderedPhotos renderings_;
  Directions directions_;
  std::deque<Taken> held_;
  ConsistencyReport report_;
};

}  // namespace

ConsistencyReport hold_against(const Evidence& evidence, const LayeredPanorama& panorama,
                               const ConsistencyOptions& options, const Job& job, const AgreementSink& sink,
                               const std::vector<consistency::Observer*>& observers) {
  return Holding(evidence, panorama, options, job, observers).run(sink);
}

}  // namespace ldp
