#include "expansion.h"

#include <algorithm>

namespace ldp {

namespace {

size_t at(int p) { return static_cast<size_t>(p); }

}  // namespace

void Expansion::start(LabelGrid& grid, const Smoothness& smoothness) {
  grid_ = &grid;
  smoothness_ = &smoothness;
  kernel_grid_ = grid.kernel_grid(smoothness);
  gain_.resize(at(grid.size()) * kSlots);
  negative_.resize(at(grid.size()));
  nodes_.assign(at(grid.size()), Node{});
  move_ = 0;
  for (int p = 0; p < grid.size(); ++p) compute_gains(p);
}

size_t Expansion::bytes() const {
  return gain_.capacity() * sizeof(int16_t) + negative_.capacity() * sizeof(uint16_t) +
         nodes_.capacity() * sizeof(Node) +
         (touched_.capacity() + queue_.capacity() + orphans_.capacity()) * sizeof(int);
}

// The pair term of p and its lower or right neighbour q under the move, split into unary terms and two capacities:
//   E(x_p, x_q) = E00 + unary_p x_p + unary_q x_q + capacity_pq x_p (1 - x_q) + capacity_qp (1 - x_p) x_q.
// Any split with capacities >= 0 is the same function; the one nearest to equal unary terms leaves least to the cut.
Expansion::EdgeTerms Expansion::edge_terms(int p, int direction, int alpha) const {
  const LabelGrid& grid = *grid_;
  const int q = p + grid.stride(direction), factor = grid.factor(p, direction);
  const int fp = grid.label[at(p)], fq = grid.label[at(q)];
  const uint8_t* into_p = grid.messages(p, direction);
  const uint8_t* into_q = grid.messages(q, direction ^ 1);
  const int e00 = grid.pair(*smoothness_, factor, p, fp, q, fq) - into_p[fp] - into_q[fq];
  int e10 = grid.pair(*smoothness_, factor, p, alpha, q, fq) - into_p[alpha] - into_q[fq] - e00;
  const int e01 = grid.pair(*smoothness_, factor, p, fp, q, alpha) - into_p[fp] - into_q[alpha] - e00;
  const int e11 = grid.pair(*smoothness_, factor, p, alpha, q, alpha) - into_p[alpha] - into_q[alpha] - e00;
  e10 += std::max(0, e11 - e01 - e10);
  EdgeTerms terms;
  terms.unary_p = std::clamp(e11 >> 1, e11 - e01, e10);
  terms.unary_q = e11 - terms.unary_p;
  terms.capacity_pq = e10 - terms.unary_p;
  terms.capacity_qp = e01 - terms.unary_q;
  return terms;
}

void Expansion::compute_gains(int p) {
  const unsigned negative = message_kernels().gains(kernel_grid_, p, gain_.data() + at(p) * kSlots);
  negative_[at(p)] = static_cast<uint16_t>(negative);
}

Expansion::Node& Expansion::touch(int p) {
  Node& node = nodes_[at(p)];
  if (node.move != move_) {
    node = Node{};
    node.move = move_;
    node.terminal = gain_[at(p) * kSlots + at(alpha_)];
    touched_.push_back(p);
  }
  return node;
}

void Expansion::build_edge(int p, int direction) {
  Node& node = nodes_[at(p)];
  node.edges_built = static_cast<uint8_t>(node.edges_built | 1 << direction);
  if (grid_->factor(p, direction) == 0) return;
  const int q = p + grid_->stride(direction);
  Node& other = touch(q);
  other.edges_built = static_cast<uint8_t>(other.edges_built | 1 << (direction ^ 1));
  const bool forward = direction == kDown || direction == kRight;
  const EdgeTerms terms = forward ? edge_terms(p, direction, alpha_) : edge_terms(q, direction ^ 1, alpha_);
  node.capacity[direction] = static_cast<uint16_t>(forward ? terms.capacity_pq : terms.capacity_qp);
  other.capacity[direction ^ 1] = static_cast<uint16_t>(forward ? terms.capacity_qp : terms.capacity_pq);
}

void Expansion::build_edges(int p) {
  for (int direction = 0; direction < 4; ++direction)
    if ((nodes_[at(p)].edges_built >> direction & 1) == 0) build_edge(p, direction);
}

void Expansion::activate(int p) {
  Node& node = nodes_[at(p)];
  if (node.active) return;
  node.active = true;
  queue_.push_back(p);
}

bool Expansion::expand(int alpha) {
  alpha_ = alpha;
  ++move_;
  time_ = 1;
  touched_.clear();
  queue_.clear();
  queue_head_ = 0;
  for (int p = 0; p < grid_->size(); ++p) {
    if ((negative_[at(p)] >> alpha & 1) == 0) continue;
    Node& root = touch(p);
    root.parent = kRoot;
    activate(p);
  }
  if (queue_.empty()) return false;
  while (queue_head_ < queue_.size()) {
    const int p = queue_[queue_head_++];
    nodes_[at(p)].active = false;
    grow(p);
  }
  return commit();
}

// One tree grows from the excesses; a neighbour with capacity to the sink takes flow at once and joins when it is full.
void Expansion::grow(int p) {
  if (nodes_[at(p)].parent == kFree) return;
  build_edges(p);
  for (int direction = 0; direction < 4; ++direction) {
    if (nodes_[at(p)].capacity[direction] == 0) continue;
    const int q = p + grid_->stride(direction);
    Node& next = touch(q);
    while (next.parent == kFree && next.terminal > 0 && nodes_[at(p)].capacity[direction] > 0) {
      augment(p, direction);
      if (nodes_[at(p)].parent == kFree) return;
    }
    const Node& node = nodes_[at(p)];
    if (next.parent != kFree || node.capacity[direction] == 0) continue;
    next.parent = static_cast<uint8_t>(1 + (direction ^ 1));
    next.distance = static_cast<uint16_t>(node.distance + 1);
    next.stamp = node.stamp;
    activate(q);
  }
}

void Expansion::augment(int p, int direction) {
  Node& sink = nodes_[at(p + grid_->stride(direction))];
  int flow = std::min<int>(sink.terminal, nodes_[at(p)].capacity[direction]);
  int root = p;
  while (nodes_[at(root)].parent != kRoot) {
    const int up = nodes_[at(root)].parent - 1;
    root += grid_->stride(up);
    flow = std::min<int>(flow, nodes_[at(root)].capacity[up ^ 1]);
  }
  flow = std::min(flow, -nodes_[at(root)].terminal);

  sink.terminal -= flow;
  const auto push = [&](int from, int towards) {
    Node& node = nodes_[at(from)];
    Node& other = nodes_[at(from + grid_->stride(towards))];
    node.capacity[towards] = static_cast<uint16_t>(node.capacity[towards] - flow);
    other.capacity[towards ^ 1] = static_cast<uint16_t>(other.capacity[towards ^ 1] + flow);
    return node.capacity[towards] == 0;
  };
  push(p, direction);
  for (int child = p; child != root;) {
    const int up = nodes_[at(child)].parent - 1;
    const int parent = child + grid_->stride(up);
    if (push(parent, up ^ 1)) orphans_.push_back(child);
    child = parent;
  }
  nodes_[at(root)].terminal += flow;
  if (nodes_[at(root)].terminal == 0) orphans_.push_back(root);
  adopt_orphans();
}

void Expansion::adopt_orphans() {
  ++time_;
  for (const int p : orphans_) nodes_[at(p)].parent = 6;  // in the tree, but without a parent
  while (!orphans_.empty()) {
    const int p = orphans_.back();
    orphans_.pop_back();
    if (!adopt(p)) release(p);
  }
}

// Whether the chain of parents of a tree node ends in a root; its length. Marks the chain so that it is walked once.
bool Expansion::rooted(int p, int& distance) {
  int length = 0, walk = p;
  while (nodes_[at(walk)].stamp != time_) {
    const uint8_t parent = nodes_[at(walk)].parent;
    if (parent == kFree || parent > kRoot) return false;
    if (parent == kRoot) {
      nodes_[at(walk)].stamp = time_;
      nodes_[at(walk)].distance = 0;
      break;
    }
    walk += grid_->stride(parent - 1);
    ++length;
  }
  distance = length + nodes_[at(walk)].distance;
  for (int d = distance, node = p; node != walk; node += grid_->stride(nodes_[at(node)].parent - 1)) {
    nodes_[at(node)].stamp = time_;
    nodes_[at(node)].distance = static_cast<uint16_t>(d--);
  }
  return true;
}

bool Expansion::adopt(int p) {
  build_edges(p);
  int best = 1 << 30, best_direction = -1;
  for (int direction = 0; direction < 4; ++direction) {
    if (grid_->factor(p, direction) == 0) continue;
    const int q = p + grid_->stride(direction);
    if (nodes_[at(q)].parent == kFree || nodes_[at(q)].capacity[direction ^ 1] == 0) continue;
    int distance = 0;
    if (!rooted(q, distance) || distance >= best) continue;
    best = distance;
    best_direction = direction;
  }
  if (best_direction < 0) return false;
  Node& node = nodes_[at(p)];
  node.parent = static_cast<uint8_t>(1 + best_direction);
  node.distance = static_cast<uint16_t>(best + 1);
  node.stamp = time_;
  return true;
}

void Expansion::release(int p) {
  Node& node = nodes_[at(p)];
  node.parent = kFree;
  for (int direction = 0; direction < 4; ++direction) {
    if (grid_->factor(p, direction) == 0) continue;
    const int q = p + grid_->stride(direction);
    Node& other = nodes_[at(q)];
    if (other.parent == kFree) continue;
    if (other.capacity[direction ^ 1] > 0) activate(q);
    if (other.parent == 1 + (direction ^ 1)) {
      other.parent = 6;
      orphans_.push_back(q);
    }
  }
}

// What is still in the tree could not spend its excess: it takes alpha.
bool Expansion::commit() {
  bool changed = false;
  for (const int p : touched_) {
    if (nodes_[at(p)].parent == kFree || grid_->label[at(p)] == alpha_) continue;
    grid_->label[at(p)] = static_cast<uint8_t>(alpha_);
    changed = true;
  }
  if (!changed) return false;
  for (const int p : touched_) {
    if (nodes_[at(p)].parent == kFree) continue;
    compute_gains(p);
    for (int direction = 0; direction < 4; ++direction) {
      if (grid_->factor(p, direction) == 0) continue;
      const int q = p + grid_->stride(direction);
      if (nodes_[at(q)].move != move_ || nodes_[at(q)].parent == kFree) compute_gains(q);
    }
  }
  return true;
}

}  // namespace ldp
