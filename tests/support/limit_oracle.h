#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace takt::test {

/// Judges a sequence of sampled positions against limits, knowing nothing of how it was made: it only differences.
///
/// The n-th difference over period^n is a weighted mean of the n-th derivative over n periods, so a motion that keeps
/// its limits never shows more in it, but for the rounding of the samples: an error e of each sample shows as
/// 2 e / T, 4 e / T^2, 8 e / T^3 in the three differences, and that is all that is forgiven.
class LimitOracle {
 public:
  struct Limits {
    std::vector<double> lower, upper, velocity, acceleration, jerk;
  };
  /// The largest share of a limit that was used; > 1 = broken.
  struct Worst {
    double share = 0.0;
    std::size_t axis = 0;
    long sample = -1;
  };

  LimitOracle(Limits limits, double period, double sample_error)
      : limits_(std::move(limits)), period_(period), error_(sample_error) {}

  void add(const std::vector<double>& q) {
    for (std::size_t back = 3; back > 0; --back) last_[back] = last_[back - 1];
    last_[0] = q;
    ++count_;
    for (std::size_t i = 0; i < q.size(); ++i) judge(i);
  }

  Worst velocity, acceleration, jerk;
  double range_excess = -1e300;  ///< how far the worst sample lies outside its range; negative inside

 private:
  void judge(std::size_t i) {
    const double T = period_;
    const auto q = [&](std::size_t back) { return last_[back][i]; };
    range_excess = std::max({range_excess, limits_.lower[i] - q(0), q(0) - limits_.upper[i]});
    if (count_ >= 2) note(velocity, i, (q(0) - q(1)) / T, 2 * error_ / T, limits_.velocity[i]);
    if (count_ >= 3) {
      note(acceleration, i, (q(0) - 2 * q(1) + q(2)) / (T * T), 4 * error_ / (T * T), limits_.acceleration[i]);
    }
    if (count_ >= 4) {
      const double third = q(0) - 3 * q(1) + 3 * q(2) - q(3);
      note(jerk, i, third / (T * T * T), 8 * error_ / (T * T * T), limits_.jerk[i]);
    }
  }

  void note(Worst& worst, std::size_t axis, double value, double forgiven, double limit) const {
    const double share = (std::abs(value) - forgiven) / limit;
    if (share > worst.share || std::isnan(share)) worst = {share, axis, count_ - 1};
  }

  Limits limits_;
  double period_;
  double error_;
  long count_ = 0;
  std::array<std::vector<double>, 4> last_;
};

}  // namespace takt::test
