#pragma once

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/core/activity/two_arm_cell.h"
#include "tests/core/program/tree/program_runs.h"
#include "tests/support/limit_oracle.h"

namespace takt::test {

/// Programs on two arms that move as one.
class PairProgramTest : public ProgramRuns, public TwoArmCell {
 protected:
  static std::string sequence(const std::string& steps) { return R"({"do": "sequence", "steps": [)" + steps + "]}"; }
  /// A LIN of both; `more` are keys with a comma before them.
  static std::string both(const char* name, const char* by, const std::string& more = kBlend) {
    return fmt::format(R"({{"do": "lin", "arm": "left", "follower": "right", "name": "{}", "to": {{"by_m": [{}]}}{}}})",
                       name, by, more);
  }
  static constexpr const char* kBlend = R"(, "blend_m": 0.03)";
  static constexpr const char* kLog = R"({"do": "log", "text": "x"},)";
  static constexpr const char* kArc =
      R"({"do": "circ", "arm": "left", "follower": "right", "name": "round", "via": {"by_m": [0.03, 0.03, 0]},
          "to": {"by_m": [0, 0.06, 0]}})";
  static std::string squeezed(double newton) {
    return fmt::format(R"({{"internal_force": ["left wrist", "right wrist"], "above_N": {}}})", newton);
  }
  static std::string unless(double newton) { return R"(, "abort_if": )" + squeezed(newton); }

  using ProgramRuns::run;
  operations::Progress run(const std::string& text, const AtCycle& at_cycle = {}) { return run(good(text), at_cycle); }

  /// Neither in the first nor in the last motion's ramps: between begin and end of what moves.
  bool on_the_way() const {
    return std::ranges::any_of(log, [](const auto& line) { return line == "program: end up"; }) &&
           !std::ranges::any_of(log, [](const auto& line) { return line == "program: end last"; });
  }
  const device::Arm& device_of(const std::string& name) const { return *cell.arms.at(name).device; }
  Eigen::Isometry3d flange(const std::string& name) const {
    return *cell.frames.pose(name) * arm->chain->forward(device_of(name).set_point().q);
  }
  /// The follower's flange in the leader's, by what was sent.
  Eigen::Isometry3d X_LF() const { return flange("left").inverse() * flange("right"); }
  Eigen::Vector3d tool() const { return flange("left").translation(); }
  double speed(const std::string& name) const { return device_of(name).set_point().dq.cwiseAbs().maxCoeff(); }
  /// They push against each other with so much, along the world's x.
  void squeeze(double newton) {
    for (const char* name : {"left", "right"}) {
      const Eigen::Vector3d push_W = (name[0] == 'l' ? newton : -newton) * Eigen::Vector3d::UnitX();
      wrists[name]->sample.wrench.force = flange(name).linear().transpose() * push_W;
    }
  }

  /// Rows L6, P2: wherever it is cancelled, both come to rest on the path, together, and are free again: they go home.
  void cancel_at_every(int step, const program::Program& cancelled) {
    const program::Program home = good(R"({"do": "parallel", "branches": [{"do": "ptp", "arm": "left", "to": "home"},
                                                {"do": "ptp", "arm": "right", "to": "home"}]})");
    ASSERT_EQ(run(cancelled), operations::Progress::kDone) << diagnostics.to_string();
    const int whole = cycles;
    for (int at = 0; at < whole; at += step) {
      SCOPED_TRACE(at);
      ASSERT_EQ(run(cancelled, cancelling(at)), operations::Progress::kDone);
      EXPECT_LT(cycles, at + 800);
      EXPECT_LT(apart, 1e-9);
      EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
      for (const char* name : {"left", "right"}) {
        EXPECT_TRUE(device_of(name).at_rest());
        EXPECT_FALSE(device_of(name).held());
      }
      ASSERT_EQ(run(home), operations::Progress::kDone) << "the arms are free again";
    }
  }

  void expect_good_end() {
    for (int i = 0; i < 600; ++i) core.step();
    for (const char* name : {"left", "right"}) {
      EXPECT_TRUE(device_of(name).at_rest()) << name;
      EXPECT_FALSE(device_of(name).held()) << name;
      const auto list = [](const device::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
      const auto& l = arm->limits;
      LimitOracle oracle({list(l.lower), list(l.upper), list(l.velocity), list(l.acceleration), list(l.jerk)}, 1e-3,
                         1e-11);
      for (const auto& sent : backends.at(name)->sent) oracle.add(list(sent.q));
      EXPECT_LE(std::max({oracle.velocity.share, oracle.acceleration.share, oracle.jerk.share}), 1.0) << name;
    }
  }

  int standing = 0;
  double apart = 0.0;
  Eigen::Isometry3d X_LF_first = Eigen::Isometry3d::Identity();

 private:
  [[nodiscard]] expression::Cell& programs_cell() override { return cell; }
  [[nodiscard]] rcc::ControlCore& programs_core() override { return core; }
  void before_first_cycle() override {
    X_LF_first = X_LF();
    apart = 0.0;
    standing = 0;
  }
  void one_cycle() override {
    core.step();
    apart = std::max(apart, (X_LF().matrix() - X_LF_first.matrix()).cwiseAbs().maxCoeff());
    standing += on_the_way() && speed("left") < 1e-4;
  }
};

}  // namespace takt::test
