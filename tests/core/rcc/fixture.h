#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/motion/path.h"
#include "core/motion/path_clock.h"
#include "core/motion/time_law.h"
#include "core/rcc/control_core.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/fake_arm.h"
#include "tests/support/guarded_step.h"
#include "tests/support/limit_oracle.h"

namespace takt::test {

using device::JointVector;
using net::NetDescription;
using Json = nlohmann::ordered_json;

inline constexpr int kFakeJoints = 3;

/// A joint line from rest to rest inside the fake arm's limits, by a law with room for the path clock.
struct PlannedLine {
  motion::JointLine line;
  motion::TimeLaw law;
  motion::ClockBounds bounds{.acceleration_max = 4.0, .jerk_max = 80.0};

  PlannedLine(const JointVector& start, const JointVector& goal) : line{start, goal} {
    const double way = (goal - start).cwiseAbs().maxCoeff();
    law = motion::TimeLaw::rest_to_rest({.velocity = 0.8 / way, .acceleration = 2.0 / way, .jerk = 40.0 / way});
  }
};

/// Clock, law, line and command of one arm as a net: what the generic mapping makes of a PTP. The clock's target is
/// 1 until `stop_port` is true, then 0; the net ends at the end of the path, or at rest after a cancel.
inline NetDescription ptp_net(const std::string& name, const std::string& arm, const PlannedLine& plan) {
  NetDescription net;
  net.name = name;
  net.add("cancel", "Cancel");
  net.add("target", "SelectReal", {{"if_true", 0.0}, {"if_false", 1.0}});
  net.add("clock", "PathClock",
          {{"bounds", motion::to_json(plan.bounds)},
           {"duration", plan.law.duration()},
           {"in_motion", plan.law.begins_in_motion()}});
  net.add("law", "TimeLaw", {{"law", motion::to_json(plan.law)}});
  net.add("line", "JointLine", {{"path", motion::to_json(motion::Path(plan.line))}});
  net.add("arm", "ArmCommand", {{"device", arm}});
  net.add("stopped", "And");
  net.add("over", "Or");
  net.add("end", "Termination");
  net.link("cancel.requested", "target.condition").link("target.value", "clock.target_rate");
  for (const char* port : {"time", "rate", "rate_derivative"})
    net.link(std::string("clock.") + port, std::string("law.") + port);
  for (const char* port : {"s", "ds", "dds"}) net.link(std::string("law.") + port, std::string("line.") + port);
  for (const char* port : {"q", "dq", "ddq"}) net.link(std::string("line.") + port, std::string("arm.") + port);
  net.link("cancel.requested", "stopped.a").link("clock.standstill", "stopped.b");
  net.link("clock.at_end", "over.a").link("stopped.value", "over.b").link("over.value", "end.condition");
  return net;
}

/// A control core with two fake arms, "left" and "right", at zero.
class CoreTest : public testing::Test {
 protected:
  CoreTest() { build({}); }

  void build(const rcc::ControlCore::Options& options) {
    core = std::make_unique<rcc::ControlCore>(options);
    left_backend = add_arm("left");
    right_backend = add_arm("right");
    guarded_step(*core);  // the arms become ready
  }

  std::shared_ptr<FakeArm> add_arm(const std::string& name) {
    auto backend = std::make_shared<FakeArm>(JointVector::Zero(kFakeJoints));
    core->add(std::make_unique<device::Arm>(name, description, backend, core->period()));
    return backend;
  }

  rcc::NetId load(const NetDescription& net, const rcc::LoadOptions& options = {}) {
    auto id = core->load(net, options);
    if (!id) ADD_FAILURE() << id.error().to_string();
    return id.value_or(0);
  }

  /// Cycles that must not allocate.
  void steps(int count) {
    for (int i = 0; i < count; ++i) guarded_step(*core);
  }

  /// Steps until the net has ended. @return false after `most` cycles.
  bool run_to_end(rcc::NetId net, int most = 20'000) {
    while (core->state(net) != rcc::NetState::kTerminated && most-- > 0) steps(1);
    return core->state(net) == rcc::NetState::kTerminated;
  }

  /// The first event of a kind in the last step.
  const rcc::Event* event(rcc::Event::Kind kind) const {
    for (const rcc::Event& one : core->events())
      if (one.kind == kind) return &one;
    return nullptr;
  }

  static LimitOracle judge(const FakeArm& arm, const motion::JointLimits& limits) {
    const auto list = [](const JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
    LimitOracle oracle(
        {list(limits.lower), list(limits.upper), list(limits.velocity), list(limits.acceleration), list(limits.jerk)},
        1e-3, 1e-15);
    for (const auto& set_point : arm.sent) oracle.add(list(set_point.q));
    return oracle;
  }

  void expect_limits_kept(const FakeArm& arm) const {
    const auto oracle = judge(arm, description->limits);
    EXPECT_LE(oracle.velocity.share, 1.001);
    EXPECT_LE(oracle.acceleration.share, 1.001);
    EXPECT_LE(oracle.jerk.share, 1.001) << "axis " << oracle.jerk.axis << " sample " << oracle.jerk.sample;
  }

  static JointVector joints(double a, double b, double c) {
    JointVector q(3);
    q << a, b, c;
    return q;
  }

  std::shared_ptr<const device::ArmDescription> description =
      std::make_shared<const device::ArmDescription>(fake_arm_description(kFakeJoints));
  std::unique_ptr<rcc::ControlCore> core;
  std::shared_ptr<FakeArm> left_backend, right_backend;
};

}  // namespace takt::test
