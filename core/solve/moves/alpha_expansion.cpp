#include "core/solve/moves/alpha_expansion.h"

#include <algorithm>

namespace ldp::solve {

namespace {

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
         nodes_.capacity() * sizeof(Node) + touched_.capacity() * sizeof(int) + flow_bytes();
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

void Expansion::build_links(int p) {
  const uint8_t& flags = nodes_[at(p)].flags;
  if ((flags & kAllEdges) == kAllEdges) return;
  for (int direction = 0; direction < 4; ++direction)
    if ((flags >> direction & 1) == 0) build_edge(p, direction);
}

bool Expansion::expand(int alpha) {
  alpha_ = alpha;
  ++move_;
  touched_.clear();
  clear();
  seed(dilated(dirty_[at(alpha)]));
  dirty_[at(alpha)] = 0;
  if (!has_roots()) return false;
  run();
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
        touch(p);
        add_root(p);
      }
    }
  }
}

// What lies on the source's side of the cut takes alpha.
bool Expansion::commit() {
  uint64_t changed = 0;  // blocks
  for (const int p : touched_) {
    if (!on_source_side(p) || grid_->label[at(p)] == alpha_) continue;
    grid_->label[at(p)] = static_cast<uint8_t>(alpha_);
    const int block = p / grid_->height / block_width_ * 8 + p % grid_->height / block_height_;
    changed |= uint64_t{1} << block;
  }
  if (changed == 0) return false;
  for (int slot = 0; slot < kSlots; ++slot)
    if (slot != alpha_) dirty_[at(slot)] |= changed;
  for (const int p : touched_) {
    if (!on_source_side(p)) continue;
    compute_gains(p);
    for (int direction = 0; direction < 4; ++direction) {
      if (grid_->factor(p, direction) == 0) continue;
      const int q = p + grid_->stride(direction);
      if (nodes_[at(q)].move != move_ || !on_source_side(q)) compute_gains(q);
    }
  }
  return true;
}

}  // namespace ldp::solve
