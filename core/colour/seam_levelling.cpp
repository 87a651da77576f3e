#include "core/colour/seam_levelling.h"

#include <algorithm>
#include <cmath>

#include "core/colour/colour_tuning.h"

namespace ldp::colour {
namespace {

using namespace tuning;

struct Link {
  int to = 0;
  double weight = 0;
  std::array<double, 3> step{};  // weighted sum of offset(to) wanted minus offset(from)
};

struct Node {
  int source = 0;
  int pixels = 0;
  std::vector<Link> links;
  std::array<double, 3> offset{};
};

// (cell, photograph) pairs of the panorama, all layers together: an exposure does not depend on the layer.
class OffsetField {
 public:
  OffsetField(const PanoramaGrid& grid, int cell_px)
      : grid_(grid),
        cell_px_(cell_px),
        columns_((grid.width + cell_px - 1) / cell_px),
        rows_((grid.height + cell_px - 1) / cell_px),
        nodes_(static_cast<size_t>(columns_) * static_cast<size_t>(rows_)) {}

  void count(const SourceMap& source) {
    for (int y = 0; y < grid_.height; ++y)
      for (int x = 0; x < grid_.width; ++x)
        if (source.at(x, y) != kNoSource) ++index(cell_of(x, y), source.at(x, y)).pixels;
  }

  void number() {
    first_.assign(nodes_.size() + 1, 0);
    for (size_t c = 0; c < nodes_.size(); ++c) first_[c + 1] = first_[c] + static_cast<int>(nodes_[c].size());
  }

  void link_neighbours() {
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) {
        const bool last = column + 1 == columns_;
        if (!last || grid_.wraps) link_cells(cell(column, row), cell(last ? 0 : column + 1, row));
        if (row + 1 < rows_) link_cells(cell(column, row), cell(column, row + 1));
      }
  }

  void add(const SeamSample& s) {
    const int own = find(cell_of(s.x, s.y), s.own), other = find(cell_beside(s), s.other);
    if (own < 0 || other < 0) return;
    std::array<double, 3> step{};
    for (size_t k = 0; k < 3; ++k) step[k] = kSeamWeight * s.step[k] / kColourSteps;
    link(own, other, kSeamWeight, step);
  }

  void solve(const Job& job) {
    std::vector<Node*> all;
    for (auto& in_cell : nodes_)
      for (Node& node : in_cell) all.push_back(&node);
    const double full = static_cast<double>(cell_px_) * cell_px_;
    for (int sweep = 0; sweep < kLevellingSweeps; ++sweep) {
      job.check();
      for (Node* node : all) relax(all, kOffsetDecay * std::min(1.0, node->pixels / full) + 1e-6, *node);
    }
  }

  // Offset of one photograph at a pixel: bilinear between the cells that hold it.
  std::array<double, 3> at(int x, int y, int source) const {
    const double cx = (x + 0.5) / cell_px_ - 0.5, cy = (y + 0.5) / cell_px_ - 0.5;
    const int x0 = static_cast<int>(std::floor(cx)), y0 = static_cast<int>(std::floor(cy));
    std::array<double, 3> sum{};
    double weights = 0;
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const Node* node = node_near(x0 + i, y0 + j, source);
        if (!node) continue;
        const double w = (i ? cx - x0 : 1 - (cx - x0)) * (j ? cy - y0 : 1 - (cy - y0));
        weights += w;
        for (size_t k = 0; k < 3; ++k) sum[k] += w * node->offset[k];
      }
    if (weights > 0)
      for (double& s : sum) s /= weights;
    return sum;
  }

 private:
  size_t cell(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }
  size_t cell_of(int x, int y) const { return cell(x / cell_px_, y / cell_px_); }
  size_t cell_beside(const SeamSample& s) const {
    const int* step = kSides[s.side];
    return cell_of((s.x + step[0] + grid_.width) % grid_.width, s.y + step[1]);
  }

  Node& index(size_t c, int source) {
    for (Node& node : nodes_[c])
      if (node.source == source) return node;
    nodes_[c].push_back({.source = source, .pixels = 0, .links = {}, .offset = {}});
    return nodes_[c].back();
  }

  int find(size_t c, int source) const {
    for (size_t i = 0; i < nodes_[c].size(); ++i)
      if (nodes_[c][i].source == source) return first_[c] + static_cast<int>(i);
    return -1;
  }

  Node& node(int number) {
    const auto c = static_cast<size_t>(std::upper_bound(first_.begin(), first_.end(), number) - first_.begin() - 1);
    return nodes_[c][static_cast<size_t>(number - first_[c])];
  }

  const Node* node_near(int column, int row, int source) const {
    if (grid_.wraps) column = (column + columns_) % columns_;
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return nullptr;
    for (const Node& n : nodes_[cell(column, row)])
      if (n.source == source) return &n;
    return nullptr;
  }

  void link_cells(size_t a, size_t b) {
    const double full = static_cast<double>(cell_px_) * cell_px_;
    for (size_t i = 0; i < nodes_[a].size(); ++i) {
      const int other = find(b, nodes_[a][i].source);
      if (other < 0) continue;
      const double share = std::min(nodes_[a][i].pixels, node(other).pixels) / full;
      link(first_[a] + static_cast<int>(i), other, std::min(1.0, share) + 0.01, {});
    }
  }

  // One link a pair: a second one between the same two nodes adds to the first.
  void link(int from, int to, double weight, const std::array<double, 3>& step) {
    add_half(from, to, weight, step);
    add_half(to, from, weight, {-step[0], -step[1], -step[2]});
  }

  void add_half(int from, int to, double weight, const std::array<double, 3>& step) {
    auto& links = node(from).links;
    auto found = std::find_if(links.begin(), links.end(), [&](const Link& l) { return l.to == to; });
    if (found == links.end()) found = links.insert(links.end(), Link{.to = to, .weight = 0, .step = {}});
    found->weight += weight;
    for (size_t k = 0; k < 3; ++k) found->step[k] += step[k];
  }

  static void relax(const std::vector<Node*>& all, double decay, Node& node) {
    double weights = decay;
    std::array<double, 3> sum{};
    for (const Link& l : node.links) {
      weights += l.weight;
      for (size_t k = 0; k < 3; ++k) sum[k] += l.weight * all[static_cast<size_t>(l.to)]->offset[k] + l.step[k];
    }
    for (size_t k = 0; k < 3; ++k) node.offset[k] = sum[k] / weights;
  }

  const PanoramaGrid& grid_;
  int cell_px_, columns_, rows_;
  std::vector<std::vector<Node>> nodes_;  // by cell
  std::vector<int> first_;                // number of each cell's first node
};

uint8_t shifted(uint8_t value, double offset) {
  return static_cast<uint8_t>(std::clamp(static_cast<int>(std::lround(value + offset)), 0, 255));
}

bool is_exposure(const SeamSample& s) {
  return std::all_of(s.step.begin(), s.step.end(), [](int k) { return std::abs(k) <= kLargestStep * kColourSteps; });
}

}  // namespace

void level_seams(const PanoramaGrid& grid, const std::vector<ColourTask>& tasks, const SeamSamples& for_each_sample,
                 const ColourOptions& options, const Job& job) {
  OffsetField field(grid, options.seam_cell_px);
  for (const ColourTask& task : tasks) field.count(*task.source);
  field.number();
  field.link_neighbours();
  for_each_sample([&](const SeamSample& s) {
    if (is_exposure(s)) field.add(s);
  });
  field.solve(job);
  for (const ColourTask& task : tasks)
    parallel_for(job, grid.height, [&](int y) {
      for (int x = 0; x < grid.width; ++x) {
        const int source = task.source->at(x, y);
        if (source == kNoSource) continue;
        const auto offset = field.at(x, y, source);
        Rgb& c = task.colour->at(x, y);
        c = {shifted(c.r, offset[0]), shifted(c.g, offset[1]), shifted(c.b, offset[2])};
      }
    });
}

}  // namespace ldp::colour
