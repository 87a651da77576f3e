#include "kept_costs.h"

#include <algorithm>

namespace ldp {

namespace {

constexpr int kStripColumns = 32;

}  // namespace

KeptCosts::KeptCosts(const CostSource& source, size_t memory_bytes, const Job& job) : source_(source) {
  const size_t column = static_cast<size_t>(source.height()) * static_cast<size_t>(source.labels());
  kept_ = static_cast<int>(std::min(static_cast<size_t>(source.width()), memory_bytes / (2 * column)));
  cost_.resize(static_cast<size_t>(kept_) * column);
  median_.resize(cost_.size());
  parallel_for(job, (kept_ + kStripColumns - 1) / kStripColumns, [&](int strip) {
    const int begin = strip * kStripColumns;
    const size_t at = static_cast<size_t>(begin) * column;
    source_.read({begin, 0, std::min(kStripColumns, kept_ - begin), source_.height()}, cost_.data() + at,
                 median_.data() + at);
  });
}

void KeptCosts::read(const Window& window, uint8_t* cost, uint8_t* median) const {
  const auto labels = static_cast<size_t>(source_.labels());
  const size_t run = static_cast<size_t>(window.height) * labels;
  for (int x = 0; x < window.width;) {
    const int column = (window.x + x) % source_.width();
    const size_t to = static_cast<size_t>(x) * run;
    if (column < kept_) {
      const auto from = static_cast<ptrdiff_t>(
          (static_cast<size_t>(column) * static_cast<size_t>(source_.height()) + static_cast<size_t>(window.y)) *
          labels);
      std::copy_n(cost_.begin() + from, run, cost + to);
      std::copy_n(median_.begin() + from, run, median + to);
      ++x;
      continue;
    }
    const int missing = std::min(window.width - x, source_.width() - column);
    source_.read({column, window.y, missing, window.height}, cost + to, median + to);
    x += missing;
  }
}

}  // namespace ldp
