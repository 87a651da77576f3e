// Maximum flow, and with it the minimum cut, by growing a search tree and pushing flow along it (Boykov and Kolmogorov,
// PAMI 2004), for graphs that are known only as far as the search has come.
//
// Nodes have an excess (terminal < 0: flow from the source that waits) or a capacity to the sink (terminal > 0). One
// tree grows, from the excesses; a neighbour with capacity to the sink takes flow at once and joins when it is full.
// When no flow is left to push, what is still in the tree lies on the source's side of the cut.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace ldp::solve {

// `Graph` derives from it, makes it a friend, and has
//   kFree, kRoot, kOrphan     values of a node's `parent` that are no links; others are the link towards the parent
//   node(p)                   with terminal, parent, distance and stamp (times since `clear`); at first free
//   exchange_active(p, to)    keeps a flag of a node, gives it as it was
//   build_links(p)            makes the capacities of a node's links known
//   link_begin(p), link_end(p), link_at(i)   a node's links; link ^ 1 is the way back
//   has_link(p, link)         whether it leads anywhere
//   head(p, link), capacity(p, link)   where it leads, and what it can still carry, 0 where it leads nowhere
template <typename Graph>
class MaxFlow {
 protected:
  void clear() {
    time_ = 1;
    queue_.clear();
    queue_head_ = 0;
  }

  // A node whose excess is to be pushed.
  void add_root(int p) {
    graph().node(p).parent = Graph::kRoot;
    activate(p);
  }

  bool has_roots() const { return !queue_.empty(); }

  void run() {
    while (queue_head_ < queue_.size()) {
      const int p = queue_[queue_head_++];
      graph().exchange_active(p, false);
      grow(p);
    }
  }

  bool on_source_side(int p) { return graph().node(p).parent != Graph::kFree; }

  size_t flow_bytes() const { return (queue_.capacity() + orphans_.capacity()) * sizeof(int); }

 private:
  Graph& graph() { return static_cast<Graph&>(*this); }

  void activate(int p) {
    if (graph().exchange_active(p, true)) return;
    if (queue_.size() == queue_.capacity() && queue_head_ > queue_.size() / 2) {  // rather than grow, drop what is done
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(queue_head_));
      queue_head_ = 0;
    }
    queue_.push_back(p);
  }

  void grow(int p) {
    const auto& node = graph().node(p);
    if (node.parent == Graph::kFree) return;
    graph().build_links(p);
    for (int i = graph().link_begin(p); i < graph().link_end(p); ++i) {
      const int link = graph().link_at(i);
      const auto& capacity = graph().capacity(p, link);
      if (capacity == 0) continue;
      const int q = graph().head(p, link);
      auto& next = graph().node(q);
      while (next.parent == Graph::kFree && next.terminal > 0 && capacity > 0) {
        augment(p, link);
        if (node.parent == Graph::kFree) return;
      }
      if (next.parent != Graph::kFree || capacity == 0) continue;
      if (next.terminal < 0) {  // has an excess that was not among the roots
        add_root(q);
        continue;
      }
      assign(next.parent, link ^ 1);
      assign(next.distance, node.distance + 1);
      next.stamp = node.stamp;
      activate(q);
    }
  }

  // Sends flow along the tree to p and over a link to its head.
  void augment(int p, int link) {
    auto& sink = graph().node(graph().head(p, link));
    int flow = std::min<int>(sink.terminal, graph().capacity(p, link)), root = p;
    while (graph().node(root).parent != Graph::kRoot) {
      const int up = graph().node(root).parent, parent = graph().head(root, up);
      flow = std::min<int>(flow, graph().capacity(parent, up ^ 1));
      root = parent;
    }
    flow = std::min(flow, -graph().node(root).terminal);

    sink.terminal -= flow;
    push(p, link, flow);
    for (int child = p; child != root;) {
      const int up = graph().node(child).parent, parent = graph().head(child, up);
      if (push(parent, up ^ 1, flow)) orphan(child);
      child = parent;
    }
    graph().node(root).terminal += flow;
    if (graph().node(root).terminal == 0) orphan(root);
    adopt_orphans();
  }

  // Whether the link is full now.
  bool push(int p, int link, int flow) {
    auto &there = graph().capacity(p, link), &back = graph().capacity(graph().head(p, link), link ^ 1);
    assign(there, there - flow);
    assign(back, back + flow);
    return there == 0;
  }

  void orphan(int p) {
    graph().node(p).parent = Graph::kOrphan;
    orphans_.push_back(p);
  }

  void adopt_orphans() {
    ++time_;
    while (!orphans_.empty()) {
      const int p = orphans_.back();
      orphans_.pop_back();
      if (!adopt(p)) release(p);
    }
  }

  // Whether the chain of parents of a tree node ends in a root; its length. Marks the chain so that it is walked once.
  bool rooted(int p, int& distance) {
    int length = 0, walk = p;
    while (graph().node(walk).stamp != time_) {
      const auto parent = graph().node(walk).parent;
      if (parent == Graph::kOrphan) return false;
      if (parent == Graph::kRoot) {
        graph().node(walk).stamp = time_;
        graph().node(walk).distance = 0;
        break;
      }
      walk = graph().head(walk, parent);
      ++length;
    }
    distance = length + graph().node(walk).distance;
    for (int d = distance, step = p; step != walk; step = graph().head(step, graph().node(step).parent)) {
      graph().node(step).stamp = time_;
      assign(graph().node(step).distance, d--);
    }
    return true;
  }

  bool adopt(int p) {
    graph().build_links(p);
    int best = 1 << 30, best_link = 0;
    bool found = false;
    for (int i = graph().link_begin(p); i < graph().link_end(p); ++i) {
      const int link = graph().link_at(i);
      if (!graph().has_link(p, link)) continue;
      const int q = graph().head(p, link);
      const auto parent = graph().node(q).parent;
      if (graph().capacity(q, link ^ 1) == 0 || parent == Graph::kFree || parent == Graph::kOrphan) continue;
      int distance = 0;
      if (!rooted(q, distance) || distance >= best) continue;
      best = distance;
      best_link = link;
      found = true;
    }
    if (!found) return false;
    auto& node = graph().node(p);
    assign(node.parent, best_link);
    assign(node.distance, best + 1);
    node.stamp = time_;
    return true;
  }

  void release(int p) {
    graph().node(p).parent = Graph::kFree;
    for (int i = graph().link_begin(p); i < graph().link_end(p); ++i) {
      const int link = graph().link_at(i);
      if (!graph().has_link(p, link)) continue;
      const int q = graph().head(p, link);
      auto& other = graph().node(q);
      if (other.parent == Graph::kFree) continue;
      if (graph().capacity(q, link ^ 1) > 0) activate(q);
      if (other.parent == (link ^ 1)) orphan(q);
    }
  }

  template <typename To>
  static void assign(To& to, int value) {
    to = static_cast<To>(value);
  }

  std::vector<int> queue_, orphans_;
  size_t queue_head_ = 0;
  uint32_t time_ = 0;
};

}  // namespace ldp::solve
