#include "core/base/angles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/reports.h"

namespace takt {
namespace {

using takt::test::Warns;

bool look(std::vector<double> angles) { return look_like_radians(angles); }

TEST(Angles, PartsOfPiLookLikeRadians) {
  EXPECT_TRUE(look({3.14159, 0, 1.5708}));
  EXPECT_TRUE(look({0, 0.5, 0, 1.57, 0, -1.57, 0}));
  EXPECT_TRUE(look({0, 0, -0.785}));
  EXPECT_TRUE(look({0, 6.2832, 0}));
}

TEST(Angles, DegreesDoNot) {
  EXPECT_FALSE(look({}));
  EXPECT_FALSE(look({0, 0, 0}));
  EXPECT_FALSE(look({180, 0, 1.5708})) << "no radians are beyond a turn";
  EXPECT_FALSE(look({1, 2, 5}));
  EXPECT_FALSE(look({0.5, 0, 0}));
  EXPECT_FALSE(look({0, -30, 0, 90, 0, -60, 0}));
}

TEST(Angles, TheWarningNamesTheAngleInDegrees) {
  Diagnostics diagnostics;
  warn_of_radians(std::vector<double>{0, 0, 1.5708}, "/at/rpy_deg", diagnostics);
  EXPECT_THAT(diagnostics, Warns(Code::kInvalidValue, "/at/rpy_deg", {"1.5708", "90.0002"}));
  EXPECT_FALSE(diagnostics.has_errors());
}

}  // namespace
}  // namespace takt
