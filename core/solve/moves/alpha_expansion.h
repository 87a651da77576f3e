// Alpha-expansion inside one window by minimum cuts (maximum flow).
//
// A move offers slot alpha to every pixel of the window at once; the best subset of pixels that accepts is a minimum
// cut (Boykov, Veksler, Zabih 2001). The energy is the grid's, reparametrised by its messages: the same energy, but
// after message passing almost every pixel already prefers to keep its label, so that the cut has little to do.
// Where the weights depend on the labels a move's pair terms may fail to be submodular. Such a term is raised where one
// pixel of the pair moves (never where both keep): the cut minimises an upper bound that is exact at "all keep", so
// the true energy falls by at least what the cut gains.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/max_flow.h"

namespace ldp::solve {

class Expansion : private MaxFlow<Expansion> {
 public:
  // Prepares the moves of the grid's current labels. The grid is changed by `expand` only, until the next `start`.
  void start(LabelGrid& grid, const Smoothness& smoothness);

  // Minimises over the move to slot alpha; true if labels changed (the energy then fell). From the second call for a
  // slot on, the search begins only near pixels that changed since the last call.
  bool expand(int alpha);

  // Whether the labels near some pixel changed since the last move to this slot.
  bool pending(int alpha) const { return dirty_[static_cast<size_t>(alpha)] != 0; }

  size_t bytes() const;

 private:
  friend class MaxFlow<Expansion>;
  static constexpr uint8_t kFree = 4, kRoot = 5, kOrphan = 6;  // parents that are no direction
  static constexpr uint8_t kAllEdges = 15, kActive = 16;

  // A node of the cut graph, built when the search first touches it. Its links are the directions.
  struct Node {
    int32_t terminal = 0;       // > 0: capacity to the sink (cost of moving); < 0: excess that wants to move
    uint16_t capacity[4] = {};  // residual, towards each direction
    uint32_t stamp = 0;         // time at which `distance` was known to lead to a root
    uint32_t move = 0;          // the move that built this node
    uint16_t distance = 0;
    uint8_t parent = kFree;
    uint8_t flags = 0;  // kActive; bit per direction whose edge was built
  };

  struct EdgeTerms {
    int unary_p = 0, unary_q = 0, capacity_pq = 0, capacity_qp = 0;
  };

  EdgeTerms edge_terms(int p, int direction, int alpha) const;
  void compute_gains(int p);
  void seed(uint64_t blocks);
  Node& touch(int p);
  void build_edge(int p, int direction);
  bool commit();

  // For MaxFlow.
  Node& node(int p) { return nodes_[static_cast<size_t>(p)]; }
  bool exchange_active(int p, bool active) {
    uint8_t& flags = node(p).flags;
    const bool was = (flags & kActive) != 0;
    flags = static_cast<uint8_t>(active ? flags | kActive : flags & ~kActive);
    return was;
  }
  void build_links(int p);
  static int link_begin(int) { return 0; }
  static int link_end(int) { return 4; }
  static int link_at(int i) { return i; }
  bool has_link(int p, int direction) const { return grid_->factor(p, direction) != 0; }
  int head(int p, int direction) const { return p + offset_[direction]; }
  uint16_t& capacity(int p, int direction) { return node(p).capacity[direction]; }

  LabelGrid* grid_ = nullptr;
  const Smoothness* smoothness_ = nullptr;
  KernelGrid kernel_grid_;
  std::vector<int16_t> gain_;       // 16 per pixel: unary cost of moving to each slot
  std::vector<uint16_t> negative_;  // bit per slot whose gain is below 0
  std::vector<Node> nodes_;
  // The window in 8 x 8 blocks; per slot those with changes since the last move to it.
  std::array<uint64_t, kSlots> dirty_{};
  int block_width_ = 1, block_height_ = 1;
  std::vector<int> touched_;
  int offset_[8] = {};  // from a pixel to its neighbour by direction
  uint32_t move_ = 0;
  int alpha_ = 0;
};

}  // namespace ldp::solve
