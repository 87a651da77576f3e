#include "core/solve/moves/region_moves.h"

#include <algorithm>
#include <cstdlib>

namespace ldp::solve {

namespace {

struct GreyRange {
  int least = 255, largest = 0;

  GreyRange(const PixelTerms& terms, int p, int slots) {
    for (int slot = 0; slot < slots; ++slot) {
      least = std::min<int>(least, terms.greys(p)[slot]);
      largest = std::max<int>(largest, terms.greys(p)[slot]);
    }
  }
};

}  // namespace

Regions::Regions(int width, int height, int slots, const Smoothness& smoothness)
    : smoothness_(smoothness),
      height_(height),
      blocks_high_((height + kBlock - 1) / kBlock),
      slots_(slots),
      solved_(at(width) * at(height)),
      first_of_block_(at((width + kBlock - 1) / kBlock) * at(blocks_high_), kNone) {}

int Regions::find_node(int column, int y, uint8_t label) const {
  int node = first_of_block_[at(column / kBlock * blocks_high_ + y / kBlock)];
  while (node != kNone && nodes_[at(node)].was != label) node = nodes_[at(node)].next_of_block;
  return node;
}

int Regions::node_of(int column, int y, uint8_t label) {
  const int found = find_node(column, y, label);
  if (found != kNone) return found;
  int32_t& first = first_of_block_[at(column / kBlock * blocks_high_ + y / kBlock)];
  Node node;
  node.was = node.label = label;
  node.next_of_block = first;
  first = static_cast<int32_t>(nodes_.size());
  nodes_.push_back(node);
  return first;
}

uint8_t Regions::label_of(int column, int y, uint8_t label) const {
  return solved_[at(column * height_ + y)] ? nodes_[at(find_node(column, y, label))].label : label;
}

void Regions::add_column(const PixelTerms& terms, int first, int column, const GridSource& source,
                         const Plane<uint8_t>& labels) {
  int above = kNone;
  for (int y = 0; y < height_; ++y) {
    const int p = first + y;
    if (!terms.solved[at(p)]) {
      above = kNone;
      continue;
    }
    solved_[at(column * height_ + y)] = true;
    const int node = node_of(column, y, labels.at(column, y));
    std::array<int32_t, kSlots>& data = nodes_[at(node)].data;
    for (size_t slot = 0; slot < kSlots; ++slot) data[slot] += terms.costs(p)[slot];
    if (above != kNone && above != node)
      add_edge(terms, p - 1, p, above, node, source.edge_factor(column, y - 1, true));
    above = node;
  }
}

void Regions::add_seam(const PixelTerms& terms, int first, int next_first, int column, const GridSource& source,
                       const Plane<uint8_t>& labels) {
  const int next = (column + 1) % source.width();
  const bool same_block = column / kBlock == next / kBlock;
  for (int y = 0; y < height_; ++y) {
    const int p = first + y, q = next_first + y;
    if (!terms.solved[at(p)] || !terms.solved[at(q)]) continue;
    const uint8_t label = labels.at(column, y), other = labels.at(next, y);
    if (same_block && label == other) continue;
    add_edge(terms, p, q, find_node(column, y, label), find_node(next, y, other), source.edge_factor(column, y, false));
  }
}

Regions::Edge& Regions::edge_of(int a, int b) {
  for (int e = nodes_[at(a)].first_edge; e != kNone;) {
    Edge& edge = edges_[at(e)];
    const int side = edge.node[0] == a ? 0 : 1;
    if (edge.node[side ^ 1] == b) return edge;
    e = edge.next[side];
  }
  const auto index = static_cast<int32_t>(edges_.size());
  edges_.push_back({{a, b}, {nodes_[at(a)].first_edge, nodes_[at(b)].first_edge}, 0, 0});
  nodes_[at(a)].first_edge = nodes_[at(b)].first_edge = index;
  return edges_.back();
}

// At most 112 pixel edges meet in a block and 8 between blocks, so that sums stay below 2^16.
void Regions::add_edge(const PixelTerms& terms, int p, int q, int a, int b, int factor) {
  if (factor == 0) return;
  Edge& edge = edge_of(a, b);
  const GreyRange rp(terms, p, slots_), rq(terms, q, slots_);
  const int gap = std::max({0, rp.least - rq.largest, rq.least - rp.largest});
  edge.weight = static_cast<uint16_t>(edge.weight + smoothness_.weight(factor, gap));
  const int now = terms.pair(smoothness_, factor, p, nodes_[at(a)].was, q, nodes_[at(b)].was);
  edge.now = static_cast<uint16_t>(edge.now + now);
}

void Regions::move(int cycles, const Job& job) {
  link();
  for (int quiet = 0, i = 0; quiet < slots_ && i < cycles * slots_; ++i) {
    job.check();
    quiet = expand(i % slots_) ? 1 : quiet + 1;
  }
}

// Lists the arcs of every node.
void Regions::link() {
  cut_.assign(nodes_.size(), {});
  capacity_.assign(edges_.size() * 2, 0);
  first_arc_.assign(nodes_.size() + 1, 0);
  arcs_.assign(edges_.size() * 2, 0);
  for (size_t p = 0; p < nodes_.size(); ++p) {
    int32_t count = first_arc_[p];
    for (int e = nodes_[p].first_edge; e != kNone;) {
      const int side = edges_[at(e)].node[0] == static_cast<int>(p) ? 0 : 1;
      arcs_[at(count++)] = 2 * e + side;
      e = edges_[at(e)].next[side];
    }
    first_arc_[p + 1] = count;
  }
}

bool Regions::expand(int alpha) {
  prepare(alpha);
  run();
  return commit(alpha);
}

void Regions::prepare(int alpha) {
  for (size_t p = 0; p < nodes_.size(); ++p) {
    cut_[p] = {};
    cut_[p].terminal = nodes_[p].data[at(alpha)] - nodes_[p].data[nodes_[p].label];
  }
  for (size_t e = 0; e < edges_.size(); ++e) prepare_edge(e, alpha);
  clear();
  for (size_t p = 0; p < nodes_.size(); ++p)
    if (cut_[p].terminal < 0) add_root(static_cast<int>(p));
}

// The pair term under the move, split into two unary terms and two capacities as in Expansion::edge_terms. With one
// weight for all labels it is submodular.
void Regions::prepare_edge(size_t index, int alpha) {
  const Edge& edge = edges_[index];
  const int a = edge.node[0], b = edge.node[1], fa = nodes_[at(a)].label, fb = nodes_[at(b)].label;
  const int e10 = fa == alpha ? 0 : pair(edge, alpha, fb) - edge.now;
  const int e01 = fb == alpha ? 0 : pair(edge, fa, alpha) - edge.now;
  const int e11 = fa == alpha ? e01 : fb == alpha ? e10 : -edge.now;
  const int unary_a = std::clamp(e11 >> 1, e11 - e01, e10);
  cut_[at(a)].terminal += unary_a;
  cut_[at(b)].terminal += e11 - unary_a;
  capacity_[2 * index] = e10 - unary_a;
  capacity_[2 * index + 1] = e01 - (e11 - unary_a);
}

// What lies on the source's side of the cut takes alpha.
bool Regions::commit(int alpha) {
  const auto moves = [&](int p) { return on_source_side(p) && nodes_[at(p)].label != alpha; };
  bool changed = false;
  for (Edge& edge : edges_) {
    const int a = edge.node[0], b = edge.node[1];
    const bool a_moves = moves(a), b_moves = moves(b);
    if (!a_moves && !b_moves) continue;
    changed = true;
    edge.now =
        static_cast<uint16_t>(pair(edge, a_moves ? alpha : nodes_[at(a)].label, b_moves ? alpha : nodes_[at(b)].label));
  }
  for (size_t p = 0; p < nodes_.size(); ++p)
    if (moves(static_cast<int>(p))) {
      nodes_[p].label = static_cast<uint8_t>(alpha);
      changed = true;
    }
  return changed;
}

Energy Regions::energy() const {
  Energy energy;
  for (const Node& node : nodes_) energy.data += node.data[node.label];
  for (const Edge& edge : edges_) energy.smoothness += edge.now;
  return energy;
}

size_t Regions::bytes() const {
  return solved_.capacity() / 8 +
         (first_of_block_.capacity() + capacity_.capacity() + first_arc_.capacity() + arcs_.capacity()) *
             sizeof(int32_t) +
         flow_bytes() + nodes_.capacity() * sizeof(Node) + edges_.capacity() * sizeof(Edge) +
         cut_.capacity() * sizeof(CutNode);
}

}  // namespace ldp::solve
