#include "core/solve/moves/alpha_expansion.h"

#include <algorithm>
#include <cstddef>

namespace ldp {

namespace {

size_t at(int p) { return static_cast<size_t>(p); }

// Blocks and their 8 neighbours; bit 8 x + y.
uint64_t dilated(uint64_t blocks) {
  constexpr uint64_t kNotTop = 0xFEFEFEFEFEFEFEFE, kNotBottom = 0x7F7F7F7F7F7F7F7F;
  const uint64_t columns = blocks | ((blocks << 1) & kNotTop) | ((blocks >> 1) & kNotBottom);
  return columns | columns << 8 | columns >> 8;
}

}  // namespace

void Expansion::start(LabelGrid& grid, const Smoothness& smoothness) {
  grid_ = &grid;
  smoothness_ = &smoothness;
  kernel_grid_ = grid.kernel_grid(smoothness);
  gain_.assign(at(grid.size()) * kSlots, 0);  // `resize` would keep room for more
  negative_.assign(at(grid.size()), 0);
  nodes_.assign(at(grid.size()), Node{});
  move_ = 0;
  dirty_.fill(~uint64_t{0});
  block_width_ = (grid.width + 7) / 8;
  block_height_ = (grid.height + 7) / 8;
  for (const int direction : {kUp, kDown, kLeft, kRight}) offset_[direction] = grid.stride(direction);
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
    for (int direction = 0; direction < 4; ++direction)  // missing edges need no building
      if (grid_->factor(p, direction) == 0) node.flags = static_cast<uint8_t>(node.flags | 1 << direction);
    touched_.push_back(p);
  }
  return node;
}

void Expansion::build_edge(int p, int direction) {
  Node& node = nodes_[at(p)];
  const int q = p + offset_[direction];
  Node& other = touch(q);
  node.flags = static_cast<uint8_t>(node.flags | 1 << direction);
  other.flags = static_cast<uint8_t>(other.flags | 1 << (direction ^ 1));
  const bool forward = direction == kDown || direction == kRight;
  const EdgeTerms terms = forward ? edge_terms(p, direction, alpha_) : edge_terms(q, direction ^ 1, alpha_);
  node.capacity[direction] = static_cast<uint16_t>(forward ? terms.capacity_pq : terms.capacity_qp);
  other.capacity[direction ^ 1] = static_cast<uint16_t>(forward ? terms.capacity_qp : terms.capacity_pq);
}

void Expansion::build_edges(int p) {
  const uint8_t& flags = nodes_[at(p)].flags;
  if ((flags & kAllEdges) == kAllEdges) return;
  for (int direction = 0; direction < 4; ++direction)
    if ((flags >> direction & 1) == 0) build_edge(p, direction);
}

void Expansion::activate(int p) {
  Node& node = nodes_[at(p)];
  if ((node.flags & kActive) != 0) return;
  node.flags |= kActive;
  if (queue_.size() == queue_.capacity() && queue_head_ > queue_.size() / 2) {  // rather than grow, drop what is done
    queue_.erase(queue_.begin(), queue_.begin() + static_cast<ptrdiff_t>(queue_head_));
    queue_head_ = 0;
  }
  queue_.push_back(p);
}

bool Expansion::expand(int alpha) {
  alpha_ = alpha;
  ++move_;
  time_ = 1;
  touched_.clear();
  queue_.clear();
  queue_head_ = 0;
  seed(dilated(dirty_[at(alpha)]));
  dirty_[at(alpha)] = 0;
  if (queue_.empty()) return false;
  while (queue_head_ < queue_.size()) {
    const int p = queue_[queue_head_++];
    nodes_[at(p)].flags &= static_cast<uint8_t>(~kActive);
    grow(p);
  }
  return commit();
}

// Makes the pixels that want to move roots of the tree, in the blocks given.
void Expansion::seed(uint64_t blocks) {
  for (int x = 0; x < grid_->width; ++x) {
    const uint64_t column = blocks >> (8 * (x / block_width_)) & 255;
    for (int block = 0; block < 8; ++block) {
      if ((column >> block & 1) == 0) continue;
      const int end = std::min((block + 1) * block_height_, grid_->height);
      for (int p = x * grid_->height + block * block_height_; p < x * grid_->height + end; ++p) {
        if ((negative_[at(p)] >> alpha_ & 1) == 0) continue;
        touch(p).parent = kRoot;
        activate(p);
      }
    }
  }
}

// One tree grows from the excesses; a neighbour with capacity to the sink takes flow at once and joins when it is full.
void Expansion::grow(int p) {
  const Node& node = nodes_[at(p)];
  if (node.parent == kFree) return;
  build_edges(p);
  for (int direction = 0; direction < 4; ++direction) {
    if (node.capacity[direction] == 0) continue;
    const int q = p + offset_[direction];
    Node& next = nodes_[at(q)];  // built with the edge
    while (next.parent == kFree && next.terminal > 0 && node.capacity[direction] > 0) {
      augment(p, direction);
      if (node.parent == kFree) return;
    }
    if (next.parent != kFree || node.capacity[direction] == 0) continue;
    if (next.terminal < 0) {  // wants to move, but lies outside the blocks searched
      next.parent = kRoot;
      activate(q);
      continue;
    }
    next.parent = static_cast<uint8_t>(1 + (direction ^ 1));
    next.distance = static_cast<uint16_t>(node.distance + 1);
    next.stamp = node.stamp;
    activate(q);
  }
}

void Expansion::augment(int p, int direction) {
  Node* nodes = nodes_.data();
  Node& sink = nodes[p + offset_[direction]];
  int flow = std::min<int>(sink.terminal, nodes[p].capacity[direction]);
  int root = p;
  while (nodes[root].parent != kRoot) {
    const int up = nodes[root].parent - 1;
    root += offset_[up];
    flow = std::min<int>(flow, nodes[root].capacity[up ^ 1]);
  }
  flow = std::min(flow, -nodes[root].terminal);

  sink.terminal -= flow;
  const auto push = [&](Node& from, Node& to, int towards) {
    from.capacity[towards] = static_cast<uint16_t>(from.capacity[towards] - flow);
    to.capacity[towards ^ 1] = static_cast<uint16_t>(to.capacity[towards ^ 1] + flow);
    return from.capacity[towards] == 0;
  };
  push(nodes[p], sink, direction);
  for (int child = p; child != root;) {
    const int up = nodes[child].parent - 1;
    const int parent = child + offset_[up];
    if (push(nodes[parent], nodes[child], up ^ 1)) {
      nodes[child].parent = kOrphan;
      orphans_.push_back(child);
    }
    child = parent;
  }
  nodes[root].terminal += flow;
  if (nodes[root].terminal == 0) {
    nodes[root].parent = kOrphan;
    orphans_.push_back(root);
  }
  adopt_orphans();
}

void Expansion::adopt_orphans() {
  ++time_;
  while (!orphans_.empty()) {
    const int p = orphans_.back();
    orphans_.pop_back();
    if (!adopt(p)) release(p);
  }
}

// Whether the chain of parents of a tree node ends in a root; its length. Marks the chain so that it is walked once.
bool Expansion::rooted(int p, int& distance) {
  Node* nodes = nodes_.data();
  int length = 0, walk = p;
  while (nodes[walk].stamp != time_) {
    const uint8_t parent = nodes[walk].parent;
    if (parent == kOrphan) return false;
    if (parent == kRoot) {
      nodes[walk].stamp = time_;
      nodes[walk].distance = 0;
      break;
    }
    walk += offset_[parent - 1];
    ++length;
  }
  distance = length + nodes[walk].distance;
  for (int d = distance, step = p; step != walk; step += offset_[nodes[step].parent - 1]) {
    nodes[step].stamp = time_;
    nodes[step].distance = static_cast<uint16_t>(d--);
  }
  return true;
}

bool Expansion::adopt(int p) {
  build_edges(p);
  Node* nodes = nodes_.data();
  const bool edge[4] = {grid_->factor(p, 0) != 0, grid_->factor(p, 1) != 0, grid_->factor(p, 2) != 0,
                        grid_->factor(p, 3) != 0};
  int best = 1 << 30, best_direction = -1;
  for (int direction = 0; direction < 4; ++direction) {
    if (!edge[direction]) continue;
    const int q = p + offset_[direction];
    if (nodes[q].capacity[direction ^ 1] == 0 || nodes[q].parent == kFree || nodes[q].parent == kOrphan) continue;
    int distance = 0;
    if (!rooted(q, distance) || distance >= best) continue;
    best = distance;
    best_direction = direction;
  }
  if (best_direction < 0) return false;
  Node& node = nodes[p];
  node.parent = static_cast<uint8_t>(1 + best_direction);
  node.distance = static_cast<uint16_t>(best + 1);
  node.stamp = time_;
  return true;
}

void Expansion::release(int p) {
  nodes_[at(p)].parent = kFree;
  for (int direction = 0; direction < 4; ++direction) {
    if (grid_->factor(p, direction) == 0) continue;
    const int q = p + offset_[direction];
    Node& other = nodes_[at(q)];
    if (other.parent == kFree) continue;
    if (other.capacity[direction ^ 1] > 0) activate(q);
    if (other.parent == 1 + (direction ^ 1)) {
      other.parent = kOrphan;
      orphans_.push_back(q);
    }
  }
}

// What is still in the tree could not spend its excess: it takes alpha.
bool Expansion::commit() {
  uint64_t changed = 0;  // blocks
  for (const int p : touched_) {
    if (nodes_[at(p)].parent == kFree || grid_->label[at(p)] == alpha_) continue;
    grid_->label[at(p)] = static_cast<uint8_t>(alpha_);
    const int block = p / grid_->height / block_width_ * 8 + p % grid_->height / block_height_;
    changed |= uint64_t{1} << block;
  }
  if (changed == 0) return false;
  for (int slot = 0; slot < kSlots; ++slot)
    if (slot != alpha_) dirty_[at(slot)] |= changed;
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
