#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/kinematics/types.h"

#if defined(__clang__)
#define TAKT_UNROLL_6 _Pragma("unroll")
#else
#define TAKT_UNROLL_6 _Pragma("GCC unroll 6")
#endif

namespace takt::kinematics {

/// LU factorisation of a 6 x 6 matrix with row pivoting: a third of the time of a general one, since all loops have
/// fixed bounds. Realtime: cyclic.
class Lu6 {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// @return the smallest pivot's magnitude: 0 for a singular matrix, and then solve() must not be called.
  double factor(const Matrix6& A) {
    double smallest = std::numeric_limits<double>::infinity();
    a_ = A;
    TAKT_UNROLL_6
    for (int k = 0; k < 6; ++k) {
      int row = k;
      TAKT_UNROLL_6
      for (int i = k + 1; i < 6; ++i) {
        if (std::abs(a_(i, k)) > std::abs(a_(row, k))) row = i;
      }
      row_[static_cast<std::size_t>(k)] = row;
      if (row != k) a_.row(k).swap(a_.row(row));
      smallest = std::min(smallest, std::abs(a_(k, k)));
      if (!(smallest > 0.0)) return 0.0;
      const double inverse = 1.0 / a_(k, k);
      inverse_[static_cast<std::size_t>(k)] = inverse;
      TAKT_UNROLL_6
      for (int i = k + 1; i < 6; ++i) a_(i, k) *= inverse;
      TAKT_UNROLL_6
      for (int j = k + 1; j < 6; ++j) {
        const double factor = a_(k, j);
        TAKT_UNROLL_6
        for (int i = k + 1; i < 6; ++i) a_(i, j) -= a_(i, k) * factor;
      }
    }
    return smallest;
  }

  [[nodiscard]] Vector6 solve(Vector6 b) const {
    for (int k = 0; k < 6; ++k) std::swap(b[k], b[row_[static_cast<std::size_t>(k)]]);
    TAKT_UNROLL_6
    for (int k = 0; k < 6; ++k) {
      TAKT_UNROLL_6
      for (int i = k + 1; i < 6; ++i) b[i] -= a_(i, k) * b[k];
    }
    TAKT_UNROLL_6
    for (int k = 5; k >= 0; --k) {
      b[k] *= inverse_[static_cast<std::size_t>(k)];
      TAKT_UNROLL_6
      for (int i = 0; i < k; ++i) b[i] -= a_(i, k) * b[k];
    }
    return b;
  }

 private:
  Matrix6 a_;
  std::array<int, 6> row_{};
  std::array<double, 6> inverse_{};
};

}  // namespace takt::kinematics

#undef TAKT_UNROLL_6
