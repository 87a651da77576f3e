// Moves of whole regions, which no window is large enough to see: a textureless wall may be cheaper at another depth as
// a whole though no part of it is.
//
// The labels of a finished pass over the windows cut every block of 8 x 8 pixels into sets of equal label. Such a set
// is one node of a small graph: its data costs are sums over its pixels, and an edge between two nodes stands for all
// pixel edges between them. Alpha-expansion of the graph moves nodes, hence regions of any size, by minimum cuts.
// Inside a node labels stay equal, so its edges cost nothing at any label. Weights of edges at labels not yet taken are
// unknown here (they depend on greys); the largest that the edge's greys allow stands for them, so that the true energy
// falls by at least what a move gains. Positions other than slot numbers are not provided for.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/max_flow.h"
#include "core/solve/moves/smoothness.h"

namespace ldp::solve {

class Regions : private MaxFlow<Regions> {
 public:
  Regions(int width, int height, int slots, const Smoothness& smoothness);

  // Adds the pixels of a column of the grid, whose terms begin at pixel `first`, and the edges inside it.
  void add_column(const PixelTerms& terms, int first, int column, const GridSource& source,
                  const Plane<uint8_t>& labels);
  // Adds the edges between a column and the next, whose terms begin at pixels `first` and `next_first`. Both columns
  // must have been added.
  void add_seam(const PixelTerms& terms, int first, int next_first, int column, const GridSource& source,
                const Plane<uint8_t>& labels);

  // Moves regions until no move gains, `cycles` times over all slots at most.
  void move(int cycles, const Job& job);

  // Energy of the nodes and the edges between them; the smoothness is an upper bound once regions moved.
  Energy energy() const;

  // Label of a pixel whose label was `label` when it was added. A pixel that is not part of the problem keeps its own.
  uint8_t label_of(int column, int y, uint8_t label) const;

  size_t bytes() const;

 private:
  friend class MaxFlow<Regions>;
  static constexpr int kBlock = 8;
  static constexpr int kNone = -1;                            // ends lists
  static constexpr int kFree = -1, kRoot = -2, kOrphan = -3;  // parents that are no edges

  struct Node {
    std::array<int32_t, kSlots> data{};
    int32_t next_of_block = kNone, first_edge = kNone;
    uint8_t was = 0, label = 0;  // before any move, and now
  };
  // Of nodes a and b. Its two directions are arcs 2 i, from a to b, and 2 i + 1.
  struct Edge {
    int32_t node[2];
    int32_t next[2];       // edges of the same nodes
    uint16_t weight, now;  // the largest weight that its pixels' greys allow, summed; pair terms of the labels now
  };
  struct CutNode {
    int32_t terminal = 0;  // > 0: capacity to the sink (cost of moving); < 0: excess that wants to move
    uint32_t stamp = 0;    // time at which `distance` was known to lead to a root
    int32_t distance = 0;
    int32_t parent = kFree;  // arc towards it
    bool active = false;
  };

  int find_node(int column, int y, uint8_t label) const;
  int node_of(int column, int y, uint8_t label);
  Edge& edge_of(int a, int b);
  void add_edge(const PixelTerms& terms, int p, int q, int a, int b, int factor);
  void link();
  bool expand(int alpha);
  void prepare(int alpha);
  void prepare_edge(size_t index, int alpha);
  bool commit(int alpha);
  int pair(const Edge& edge, int a, int b) const {
    return std::min(std::abs(a - b), smoothness_.truncation()) * edge.weight;
  }

  // For MaxFlow; links are arcs.
  CutNode& node(int p) { return cut_[static_cast<size_t>(p)]; }
  bool exchange_active(int p, bool active) { return std::exchange(node(p).active, active); }
  void build_links(int) {}
  int link_begin(int p) const { return first_arc_[static_cast<size_t>(p)]; }
  int link_end(int p) const { return first_arc_[static_cast<size_t>(p) + 1]; }
  int link_at(int i) const { return arcs_[static_cast<size_t>(i)]; }
  static bool has_link(int, int) { return true; }
  int head(int, int arc) const { return edges_[static_cast<size_t>(arc / 2)].node[(arc & 1) ^ 1]; }
  int32_t& capacity(int, int arc) { return capacity_[static_cast<size_t>(arc)]; }

  const Smoothness& smoothness_;
  int height_, blocks_high_, slots_;
  std::vector<bool> solved_;  // per pixel, by columns
  std::vector<int32_t> first_of_block_;
  std::vector<Node> nodes_;
  std::vector<Edge> edges_;
  // The cut of one move.
  std::vector<CutNode> cut_;
  std::vector<int32_t> capacity_;          // residual, of each arc
  std::vector<int32_t> first_arc_, arcs_;  // of each node: arcs_[first_arc_[p] .. first_arc_[p + 1])
};

}  // namespace ldp::solve
