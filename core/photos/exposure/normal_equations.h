// Linear least squares by normal equations, in a fixed order of plain sums: the same on every machine.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace ldp::exposure {

struct Term {
  size_t unknown = 0;
  double factor = 0;
};

class NormalEquations {
 public:
  // `anchor` pulls each unknown to zero, lest some that nothing tells of have no solution; above 0.
  NormalEquations(size_t n, double anchor) : n_(n), left_(n * n, 0), right_(n, 0) {
    for (size_t i = 0; i < n; ++i) left_[i * n + i] = anchor;
  }

  // The sum of the terms shall be `value`.
  void add(std::span<const Term> terms, double value, double weight) {
    for (const Term& row : terms) {
      for (const Term& column : terms) left_[row.unknown * n_ + column.unknown] += weight * row.factor * column.factor;
      right_[row.unknown] += weight * row.factor * value;
    }
  }

  // Gauss without pivots: the matrix is symmetric and positive definite. Uses the equations up.
  std::vector<double> solution() {
    for (size_t i = 0; i < n_; ++i)
      for (size_t row = i + 1; row < n_; ++row) {
        const double share = left_[row * n_ + i] / left_[i * n_ + i];
        if (share == 0) continue;
        for (size_t k = i; k < n_; ++k) left_[row * n_ + k] -= share * left_[i * n_ + k];
        right_[row] -= share * right_[i];
      }
    std::vector<double> x(right_);
    for (size_t i = n_; i-- > 0;) {
      for (size_t k = i + 1; k < n_; ++k) x[i] -= left_[i * n_ + k] * x[k];
      x[i] /= left_[i * n_ + i];
    }
    return x;
  }

 private:
  size_t n_;
  std::vector<double> left_, right_;
};

}  // namespace ldp::exposure
