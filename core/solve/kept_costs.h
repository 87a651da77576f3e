// A cost source that keeps as many columns of another as a budget allows, so that they are computed once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cost_source.h"
#include "job.h"

namespace ldp {

class KeptCosts final : public CostSource {
 public:
  // Reads the first columns of the source, what fits into memory_bytes. The source must outlive this.
  KeptCosts(const CostSource& source, size_t memory_bytes, const Job& job);
  int width() const override { return source_.width(); }
  int height() const override { return source_.height(); }
  int labels() const override { return source_.labels(); }
  bool wraps() const override { return source_.wraps(); }
  void read(const Window& window, uint8_t* cost, uint8_t* median) const override;
  size_t bytes() const { return cost_.capacity() + median_.capacity(); }

 private:
  const CostSource& source_;
  int kept_ = 0;  // columns
  std::vector<uint8_t> cost_, median_;
};

}  // namespace ldp
