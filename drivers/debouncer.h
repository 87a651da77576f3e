// One clean press out of a bouncing contact: a level counts once it has held still for the settling time.
// Pure: the caller brings edges, levels and the time.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/interface/button.h"

namespace ldp {

class Debouncer {
 public:
  Debouncer(bool level, int64_t settle_ns) : reported_(level), settle_ns_(settle_ns) {}

  // An edge was seen; the event that may come of it is dated by the first edge of the bounce.
  void edge(int64_t time_ns) {
    if (!first_edge_ns_) first_edge_ns_ = time_ns;
    deadline_ns_ = time_ns + settle_ns_;
  }

  // When `settle` wants to be called; none while the contact rests.
  std::optional<int64_t> deadline_ns() const { return first_edge_ns_ ? deadline_ns_ : std::nullopt; }

  // The contact has been at `level` since the last edge.
  std::optional<ButtonEvent> settle(bool level, int64_t now_ns) {
    if (!first_edge_ns_ || now_ns < *deadline_ns_) return std::nullopt;
    const int64_t time_ns = *first_edge_ns_;
    first_edge_ns_.reset();
    if (level == reported_) return std::nullopt;
    reported_ = level;
    return ButtonEvent{level, time_ns};
  }

 private:
  bool reported_;
  int64_t settle_ns_;
  std::optional<int64_t> first_edge_ns_, deadline_ns_;
};

}  // namespace ldp
