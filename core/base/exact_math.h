// Elementary functions whose last bit is the same on every machine: plain additions, multiplications and divisions in a
// fixed order (IEEE 754 double, no contraction), unlike libm's, which may differ between processors. For values that
// are rounded to integers on which results depend. Accurate to about 1e-15, relative to 1 for sine and cosine.
#pragma once

#include <Eigen/Core>

namespace ldp {

struct SineCosine {
  double sine = 0, cosine = 1;
};

SineCosine exact_sine_cosine(double angle_rad);  // |angle| < 1e5
double exact_log(double x);                      // x > 0, finite and normal
double exact_exp(double x);                      // |x| < 700

// The nearest multiple of 2^-bits times the power of two at or below `scale` > 0. Rounds away what different machines
// make of the last bits of a fit, where a result is to be the same bytes on all of them and needs no such precision.
double rounded(double x, int bits, double scale = 1);

// Sums of three products from left to right: Eigen's products may fuse or reorder them, as the vector unit has it.
inline double exact_dot(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

inline Eigen::Vector3d exact_product(const Eigen::Matrix3d& m, const Eigen::Vector3d& x) {
  return {m(0, 0) * x.x() + m(0, 1) * x.y() + m(0, 2) * x.z(), m(1, 0) * x.x() + m(1, 1) * x.y() + m(1, 2) * x.z(),
          m(2, 0) * x.x() + m(2, 1) * x.y() + m(2, 2) * x.z()};
}

// The transpose of m times x.
inline Eigen::Vector3d exact_transposed_product(const Eigen::Matrix3d& m, const Eigen::Vector3d& x) {
  return {m(0, 0) * x.x() + m(1, 0) * x.y() + m(2, 0) * x.z(), m(0, 1) * x.x() + m(1, 1) * x.y() + m(2, 1) * x.z(),
          m(0, 2) * x.x() + m(1, 2) * x.y() + m(2, 2) * x.z()};
}

}  // namespace ldp
