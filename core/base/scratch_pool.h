// Buffers that threads borrow: as many exist as were ever out at once, kept to be used again.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace ldp {

// Scratch: default constructible.
template <typename Scratch>
class ScratchPool {
 public:
  // As the last borrower left it, or a new one.
  std::unique_ptr<Scratch> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<Scratch>();
    auto scratch = std::move(idle_.back());
    idle_.pop_back();
    return scratch;
  }

  void give_back(std::unique_ptr<Scratch> scratch) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(scratch));
  }

  // Of those not out; Scratch has bytes().
  size_t bytes() const {
    size_t sum = 0;
    for (const auto& scratch : idle_) sum += scratch->bytes();
    return sum;
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> idle_;
};

}  // namespace ldp
