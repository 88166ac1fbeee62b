#include "core/motion/curve.h"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace takt::motion {
namespace {

using Json = nlohmann::ordered_json;

Curve make(const Json& json, Curve::Form form) {
  auto curve = Curve::from_json(json, form);
  EXPECT_TRUE(curve) << curve.error().to_string();
  return *curve;
}

TEST(Curve, LinearMeetsItsPointsAndTheMiddle) {
  const Curve curve = make({{0.0, 1.0, -1.0}, {1.0, 3.0, 0.0}, {3.0, 2.0, 8.0}}, Curve::Form::kLinear);
  EXPECT_EQ(curve.at(0.0).y[0], 1.0);
  EXPECT_EQ(curve.at(1.0).y[0], 3.0);
  EXPECT_EQ(curve.at(3.0).y[1], 8.0);
  EXPECT_DOUBLE_EQ(curve.at(2.0).y[0], 2.5);
  EXPECT_DOUBLE_EQ(curve.at(2.0).dy[1], 4.0);
  EXPECT_DOUBLE_EQ(curve.at(1.0).dy[0], -0.5);  // behind the corner
  EXPECT_EQ(curve.at(3.5).y[0], 2.0);
  EXPECT_EQ(curve.at(3.5).dy[0], 0.0);
  EXPECT_FALSE(curve.at(3.5).inside);
  EXPECT_FALSE(curve.at(-0.1).inside);
}

/// The natural spline through three points, worked out by hand: bend in the middle = 3/2 (s1 - s0) for unit steps.
TEST(Curve, NaturalSplineByHand) {
  const Curve curve = make({{0.0, 0.0}, {1.0, 1.0}, {2.0, 0.0}}, Curve::Form::kNatural);
  EXPECT_NEAR(curve.at(1.0).ddy[0], 1.5 * (-1.0 - 1.0), 1e-15);
  EXPECT_NEAR(curve.at(0.0).ddy[0], 0.0, 1e-15);
  EXPECT_NEAR(curve.at(0.5).y[0], 0.5 + 3.0 / 16.0, 1e-15);
}

TEST(Curve, SplinesAreTwiceDifferentiable) {
  const Json points = {{0.0, 0.0}, {0.3, 1.0}, {1.1, -2.0}, {1.5, 0.4}, {2.5, 0.0}};
  for (const auto form : {Curve::Form::kNatural, Curve::Form::kRest}) {
    const Curve curve = make(points, form);
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const double x = points[i][0];
      const auto before = curve.at(x - 1e-9), behind = curve.at(x + 1e-9);
      EXPECT_NEAR(before.y[0], points[i][1].get<double>(), 1e-7);
      EXPECT_NEAR(before.dy[0], behind.dy[0], 1e-6);
      EXPECT_NEAR(before.ddy[0], behind.ddy[0], 1e-5);
    }
    for (double x = 0.01; x < 2.5; x += 0.013) {  // the derivatives are those of the values
      const double h = 1e-5;
      EXPECT_NEAR(curve.at(x).dy[0], (curve.at(x + h).y[0] - curve.at(x - h).y[0]) / (2 * h), 1e-5);
      EXPECT_NEAR(curve.at(x).ddy[0], (curve.at(x + h).dy[0] - curve.at(x - h).dy[0]) / (2 * h), 1e-2);
    }
  }
  const Curve rest = make(points, Curve::Form::kRest);
  EXPECT_NEAR(rest.at(0.0).dy[0], 0.0, 1e-12);
  EXPECT_NEAR(rest.at(2.5).dy[0], 0.0, 1e-12);
}

TEST(Curve, RefusesWhatIsNoCurveAndSaysWhere) {
  const auto fault = [](const Json& json) {
    const auto curve = Curve::from_json(json, Curve::Form::kLinear, "/points");
    return curve ? std::string() : curve.error().to_string();
  };
  EXPECT_NE(fault({{0.0, 1.0}}), "");
  EXPECT_NE(fault(3), "");
  EXPECT_NE(fault({{0.0}, {1.0}}).find("/points/0"), std::string::npos);
  EXPECT_NE(fault({{0.0, 1.0}, {1.0}, {0.5, "x"}}).find("/points/2"), std::string::npos);
  EXPECT_NE(fault({{0.0, 1.0}, {0.0, 2.0}}).find("/points/1/0"), std::string::npos);
  EXPECT_NE(fault({{0.0, 1.0}, {1.0, 1e200}}).find("/points/1"), std::string::npos);
}

}  // namespace
}  // namespace takt::motion
