#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/kinematics/types.h"

namespace takt::motion {

using kinematics::JointVector;

/// A curve through given points: y(x), one to kMaxJoints numbers each, straight between the points or twice
/// continuously differentiable (cubic spline). Immutable; thread: any.
class Curve {
 public:
  enum class Form {
    kLinear,   ///< straight lines
    kNatural,  ///< cubic, without curvature at both ends
    kRest      ///< cubic, with slope 0 at both ends
  };
  struct Sample {
    JointVector y, dy, ddy;  ///< derivatives with respect to x
    bool inside = true;      ///< x lies between the first and the last point
  };

  /// Reads [[x, y, ...], ...]: 2 to 10 000 points, x ascending, all of one size, numbers up to 1e100.
  /// @return all diagnostics, pointers below `pointer`. Realtime: setup.
  [[nodiscard]] static Result<Curve> from_json(const nlohmann::ordered_json& json, Form form,
                                               const std::string& pointer = {});

  /// How many numbers y has.
  [[nodiscard]] int dimension() const { return dimension_; }
  [[nodiscard]] double first() const { return x_.front(); }
  [[nodiscard]] double last() const { return x_.back(); }
  /// Outside of its points the curve keeps its first or last value. At a corner the slope is that behind it.
  /// Realtime: cyclic, O(log n), no allocation.
  [[nodiscard]] Sample at(double x) const;

 private:
  void bend(Form form);

  int dimension_ = 0;
  std::vector<double> x_;
  std::vector<JointVector> y_, bend_;  ///< value and second derivative at each point
};

}  // namespace takt::motion
