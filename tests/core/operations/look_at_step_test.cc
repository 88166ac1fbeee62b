// A camera on an arm keeps a moving frame in the middle of its picture.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/expression/frame_sensors.h"
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

/// A frame that a channel moves in the world, and channels for the orbit.
class LookAtTest : public test::CommandStepTest {
 protected:
  LookAtTest()
      : test::CommandStepTest([](test::CommandCell& built) {
          using net::ValueType;
          for (const char* name : {"distance", "azimuth", "elevation"}) {
            auto declared = built.core.declare(
                {.name = name, .type = ValueType::kReal, .unit = std::string(name) == "distance" ? "m" : "rad"});
            ASSERT_TRUE(declared) << declared.error().to_string();
            built.cell.channels[name] = *declared;
          }
          using Kind = world::Relation::Kind;
          EXPECT_TRUE(
              built.cell.frames.set("thing", {.kind = Kind::kChannel, .parent = "world", .source = "target"}).empty());
          EXPECT_TRUE(built.cell.frames.set("own", {.kind = Kind::kFlange, .parent = "arm", .source = "arm"}).empty());
        }) {}

  static std::string look(const std::string& more) {
    return R"({"do": "look_at", "name": "look", "at": "thing", "distance_m": 0.35, "azimuth_deg": 180,
               "elevation_deg": 60)" +
           more + "}";
  }
  static std::string orbit_by_channels() {
    return R"(, "distance_channel": "distance", "azimuth_channel": "azimuth", "elevation_channel": "elevation")";
  }
  /// Where the thing is so that the camera need not move far, in the world.
  Eigen::Vector3d in_front() const { return cell.X_WB * Eigen::Vector3d(0.5, 0.0, 0.25); }
  void put(const Eigen::Vector3d& p_W) {
    net::Frame X = net::Frame::Identity();
    X.translation() = p_W;
    (void)cell.cell.channels.at("target")->write(X);
    thing = p_W;
  }
  /// Where the thing is in the camera, m: x and y are 0 when it is in the middle.
  Eigen::Vector3d seen() const { return cell.tool_in_world(cell.q()).inverse() * thing; }
  double off_axis_deg() const {
    const Eigen::Vector3d p = seen();
    return std::atan2(p.head<2>().norm(), p.z()) * 180.0 / std::numbers::pi;
  }
  Eigen::Vector3d thing = Eigen::Vector3d::Zero();
};

TEST_F(LookAtTest, AFrameThatMovesStaysInTheMiddleAtItsDistance) {
  const program::Program program = good(look(R"(, "seconds": 8)"));
  const Eigen::Vector3d from = in_front();
  double worst_m = 0.0, worst_deg = 0.0;
  EXPECT_EQ(
      run(program,
          [&](int cycle, program::ProgramRunner&) {
            // To and fro at 0.1 m/s at most, after time to get there.
            const double t = std::max(0.0, cycle * 1e-3 - 3.0), w = 2.0;
            put(from + Eigen::Vector3d(0.05 * (1.0 - std::cos(w * t)), 0.02 * std::sin(w * t) * std::sin(w * t), 0));
            if (cycle < 3000) return;
            worst_m = std::max(worst_m, std::abs(seen().norm() - 0.35));
            worst_m = std::max(worst_m, seen().head<2>().norm());
            worst_deg = std::max(worst_deg, off_axis_deg());
          }),
      Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(worst_m, 0.005);
  EXPECT_LT(worst_deg, 1.0);
  RecordProperty("worst_mm", std::to_string(1e3 * worst_m));
  RecordProperty("worst_deg", std::to_string(worst_deg));
  expect_good_end();
}

TEST_F(LookAtTest, TheOperatorOrbitsAndComesNearerWhileItRuns) {
  const program::Program program = good(look(orbit_by_channels() + R"(, "seconds": 9)"));
  put(in_front());
  const auto write = [&](const char* channel, double value) { (void)cell.cell.channels.at(channel)->write(value); };
  double worst_deg = 0.0;
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  put(in_front());
                  if (cycle == 3000) {
                    EXPECT_NEAR(seen().norm(), 0.35, 1e-3) << "without a value of the channels the numbers count";
                    write("distance", 0.3);
                    write("azimuth", 200.0 * std::numbers::pi / 180.0);
                    write("elevation", 70.0 * std::numbers::pi / 180.0);
                  }
                  if (cycle > 3000) worst_deg = std::max(worst_deg, off_axis_deg());
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT(worst_deg, 1.0) << "it stays in the middle on the way";
  const Eigen::Vector3d p_W = cell.tool_in_world(cell.q()).translation() - thing;
  EXPECT_NEAR(p_W.norm(), 0.3, 1e-3);
  EXPECT_NEAR(std::asin(p_W.z() / p_W.norm()), 70.0 * std::numbers::pi / 180.0, 1e-3);
  EXPECT_NEAR(std::atan2(p_W.y(), p_W.x()), -160.0 * std::numbers::pi / 180.0, 1e-3);
  EXPECT_NEAR((cell.tool_in_world(cell.q()).linear() * Eigen::Vector3d::UnitX()).z(), 0.0, 1e-3) << "level";
  expect_good_end();
}

TEST_F(LookAtTest, OutOfReachItRestsSaysSoAndGoesOnOnceItIsReachable) {
  const program::Program program = good(look(R"(, "seconds": 9)"));
  bool rested = false;
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  const bool away = cycle >= 3000 && cycle < 5000;
                  put(in_front() + (away ? Eigen::Vector3d(0, 3, 0) : Eigen::Vector3d::Zero()));
                  if (cycle == 4500) rested = cell.core_arm().at_rest();
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(rested);
  EXPECT_TRUE(logged("the perspective is out of reach"));
  EXPECT_NEAR(seen().norm(), 0.35, 1e-3) << "it has gone on";
  expect_good_end();
}

TEST_F(LookAtTest, OrItFails) {
  const program::Program program = good(look(R"(, "seconds": 5, "on_unreachable": "fail")"));
  EXPECT_EQ(run(program, [&](int, program::ProgramRunner&) { put(in_front() + Eigen::Vector3d(0, 3, 0)); }),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kUnreachable, "/program"));
  EXPECT_LT(cycles, 1500);
  expect_good_end();
}

TEST_F(LookAtTest, WhatRidesOnTheArmItselfIsRefused) {
  EXPECT_THAT(wrong(R"({"do": "look_at", "at": "own", "seconds": 1})"), Reports(Code::kConflict, "/program/at"));
}

}  // namespace
}  // namespace takt::operations
