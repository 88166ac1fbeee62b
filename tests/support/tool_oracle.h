#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include <Eigen/Geometry>

#include "tests/support/fake_cell.h"

namespace takt::test {

/// The largest share of the limits of the tool centre point that was used by what was sent from one sample on, by
/// differences of its places in the base, which never show more than there was; > 1 = broken. Joint motions are not
/// bound by these limits. @param first  of the samples that are looked at
inline double worst_tool_share(const FakeCell& fake, std::size_t first = 0) {
  constexpr double T = 1e-3, kSampleError = 1e-11;  // s, m
  const auto& limits = fake.arm->cartesian;
  const Eigen::Isometry3d& X_FT = fake.cell.arms.at("arm").X_FT;
  std::array<Eigen::Vector3d, 4> p;
  double worst = 0.0;
  const auto note = [&worst](const Eigen::Vector3d& value, double forgiven, double limit) {
    worst = std::max(worst, (value.norm() - forgiven) / limit);
  };
  const auto& sent = fake.backend->sent;
  for (std::size_t i = first; i < sent.size(); ++i) {
    for (std::size_t back = 3; back > 0; --back) p[back] = p[back - 1];
    p[0] = (fake.arm->chain->forward(sent[i].q) * X_FT).translation();
    const std::size_t count = i - first + 1;
    if (count >= 2) note((p[0] - p[1]) / T, 2 * kSampleError / T, limits.linear_velocity);
    if (count >= 3) note((p[0] - 2 * p[1] + p[2]) / (T * T), 4 * kSampleError / (T * T), limits.linear_acceleration);
    if (count >= 4)
      note((p[0] - 3 * p[1] + 3 * p[2] - p[3]) / (T * T * T), 8 * kSampleError / (T * T * T), limits.linear_jerk);
  }
  return worst;
}

}  // namespace takt::test
