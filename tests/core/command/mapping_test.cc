// What commands become: nets that do, cycle for cycle, what the papers' figures written by hand do; when handlers act;
// what cancel, stop and conflicts do.
#include "core/command/mapping.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/motion/path_clock.h"
#include "core/net/value_json.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::command {
namespace {

using net::Cause;
using net::NetDescription;
using rcc::NetState;
using test::CommandCell;
using Json = nlohmann::ordered_json;

/// What left a cell, cycle by cycle.
struct Sent {
  std::vector<device::JointVector> arm;
  std::vector<bool> driver;
  std::int64_t cycles = 0;
  Cause::Code end = Cause::Code::kNone;
  bool operator==(const Sent&) const = default;
};

/// Runs a net in a cell of its own; `meanwhile(cell, cycle)` is called before each cycle.
Sent run(CommandCell& cell, rcc::NetId net, const std::function<void(CommandCell&, int)>& meanwhile) {
  Sent sent;
  cell.core.start(net);
  for (int i = 0; i < 20'000 && cell.core.state(net) != NetState::kTerminated; ++i) {
    meanwhile(cell, i);
    cell.step();
    sent.arm.push_back(cell.q());
    sent.driver.push_back(cell.cell.digital_outputs.at("driver")->value());
    ++sent.cycles;
  }
  sent.end = cell.core.status(net).cause.code;
  EXPECT_LE(cell.worst_limit_share(), 1.0);
  return sent;
}

using Maker = std::function<NetDescription(CommandCell&)>;

Sent run_net(const Maker& make, const std::function<void(CommandCell&, int)>& meanwhile) {
  CommandCell cell;
  const auto net = cell.core.load(make(cell));
  EXPECT_TRUE(net.has_value()) << net.error().to_string();
  return net ? run(cell, *net, meanwhile) : Sent{};
}

NetDescription net_of(const Command& command) {
  EXPECT_TRUE(plan(command).empty());
  auto mapped = map(command);
  EXPECT_TRUE(mapped.has_value()) << mapped.error().to_string();
  return mapped ? mapped->net : NetDescription{};
}

/// The parts of a motion as a person writes them: a clock that a port stops, a law, a path, an arm.
void write_motion(NetDescription& net, const motion::Motion& motion, const Eigen::Isometry3d& X_FM,
                  const std::string& stop) {
  net.add("rate", "SelectReal", {{"if_true", 0.0}, {"if_false", 1.0}}).link(stop, "rate.condition");
  net.add("clock", "PathClock",
          {{"duration", motion.duration()},
           {"bounds", motion::to_json(motion.clock)},
           {"law", motion::to_json(motion.law)}});
  net.link("rate.value", "clock.target_rate");
  net.add("law", "TimeLaw", {{"law", motion::to_json(motion.law)}});
  for (const char* port : {"time", "rate", "rate_derivative"}) {
    net.link(std::string("clock.") + port, std::string("law.") + port);
  }
  net.add("line", "CartesianLine", {{"path", motion::to_json(motion.path)}});
  for (const char* port : {"s", "ds", "dds"}) net.link(std::string("law.") + port, std::string("line.") + port);
  net.add("joints", "InverseKinematics", {{"device", "arm"}, {"tool", net::value_to_json(net::Frame(X_FM))}});
  for (const char* port : {"frame", "twist", "acceleration", "held", "held_velocity", "held_acceleration"}) {
    net.link(std::string("line.") + port, std::string("joints.") + port);
  }
  net.add("robot", "ArmCommand", {{"device", "arm"}});
  for (const char* port : {"q", "dq", "ddq"}) net.link(std::string("joints.") + port, std::string("robot.") + port);
  net.add("rest", "And").link(stop, "rest.a").link("clock.standstill", "rest.b");
  net.add("over", "Or").link("clock.at_end", "over.a").link("rest.value", "over.b");
}

motion::Motion line_of(const CommandCell& cell) {
  const auto& arm = *cell.arm;
  return *motion::plan_lin(*arm.chain, *arm.inverse, arm.limits, arm.cartesian, cell.q(), cell.moved(0, 0.1, 0.02), {},
                           {.velocity = 0.5, .X_FM = cell.cell.arms.at("arm").X_FT});
}

RuntimeCommand line_command(const CommandCell& cell, const std::string& name) {
  return {name, cell.arm_actuator(),
          planned({.motion = std::make_shared<const motion::Motion>(line_of(cell)),
                   .X_FM = cell.cell.arms.at("arm").X_FT})};
}

const auto kNothing = [](CommandCell&, int) {};

// 2010, Figs. 3 and 4: when the trajectory has ended, the gas is turned on.
TEST(Mapping, TheWeldingFigureIsWhatTheMappingGives) {
  const Maker by_hand = [](CommandCell& cell) {
    NetDescription inner, net;
    write_motion(inner, line_of(cell), cell.cell.arms.at("arm").X_FT, "asked.value");
    inner.add("asked", "Or", {{"b", false}});
    net.add("cancel", "Cancel").add("gas_on", "DefaultToBoolean", {{"fallback", false}});
    net.fragments.push_back(
        {"trajectory", net::WhenInactive::kReset, inner, {{"cancel", "asked.a"}}, {{"end", "over.value"}}});
    net.link("cancel.requested", "trajectory.cancel").link("trajectory.end", "gas_on.input");
    net::FragmentDescription gas;
    gas.id = "gas";
    gas.net.add("output", "DigitalOutput", {{"device", "driver"}, {"value", true}});
    net.fragments.push_back(gas);
    net.link("gas_on.value", "gas.active");
    net.add("end", "Termination").link("gas_on.value", "end.condition");
    return net;
  };
  const Maker mapped = [](CommandCell& cell) {
    const RuntimeCommand ignition = line_command(cell, "ignition_movement");
    const RuntimeCommand gas("gas", cell.driver(), set_value(true));
    TransactionCommand weld("weld");
    weld.add_started(ignition).add(gas).on_entered(ignition.action().completed(), start(gas));
    return net_of(weld);
  };
  const Sent expected = run_net(by_hand, kNothing);
  EXPECT_EQ(run_net(mapped, kNothing), expected);
  EXPECT_EQ(std::ranges::count(expected.driver, true), 1) << "in the last cycle of the movement";
}

// RPI 2010: a motion until a force is felt.
TEST(Mapping, TheGuardedMotionIsWhatTheMappingGives) {
  const auto meanwhile = [](CommandCell& cell, int i) {
    if (i == 150) cell.extra.force.x() = 6.0;
  };
  const Maker by_hand = [](CommandCell& cell) {
    NetDescription net;
    WaitCommand sensor("sensor", cell.hard());
    net.add("cancel", "Cancel");
    const auto parts = *map(sensor);
    for (const auto& p : parts.net.primitives) {
      if (p.id != "cancel" && p.id != "end") net.primitives.push_back(p);
    }
    for (const auto& l : parts.net.links) {
      if (!l.to.starts_with("end.") && !l.from.starts_with("cancel.")) net.links.push_back(l);
    }
    std::erase_if(net.primitives, [](const auto& p) { return p.type == "Or"; });
    std::erase_if(net.links, [](const auto& l) { return l.to.starts_with("sensor-over"); });
    net.add("felt", "SetResetLatch", {{"reset", false}}).link("greater_than.value", "felt.set");
    net.add("stop", "Or").link("cancel.requested", "stop.a").link("felt.value", "stop.b");
    write_motion(net, line_of(cell), cell.cell.arms.at("arm").X_FT, "stop.value");
    net.add("end", "Termination").link("over.value", "end.condition");
    return net;
  };
  const Maker mapped = [](CommandCell& cell) {
    RuntimeCommand guarded = line_command(cell, "guarded");
    guarded.on_entered(cell.hard(), cancel(guarded));
    return net_of(guarded);
  };
  EXPECT_EQ(run_net(mapped, meanwhile), run_net(by_hand, meanwhile));
}

/// Insert until it is hard; then hold the arm and turn, until the button is pressed.
TransactionCommand screwing(const CommandCell& cell) {
  RuntimeCommand insert = line_command(cell, "insert");
  const RuntimeCommand keep("keep", cell.arm_actuator(), hold()), turn("turn", cell.driver(), set_value(true));
  insert.on_entered(cell.hard(), cancel(insert));
  TransactionCommand screwing("screwing");
  screwing.add_started(insert).add(keep).add(turn);
  screwing.on_entered(insert.completed(), start(keep)).on_entered(insert.completed(), start(turn));
  screwing.on_entered(expression::digital_input(cell.cell, "button"), cancel(keep));
  return screwing;
}

// 2013, Fig. 3: insert, cancel at 5 N, then hold and turn side by side.
TEST(Mapping, TheScrewFigureIsWhatTheMappingGives) {
  const auto meanwhile = [](CommandCell& cell, int i) {
    if (i == 150) cell.extra.force.x() = 6.0;
    cell.button->sample.value = i > 900;
  };
  const Maker by_hand = [](CommandCell& cell) {
    NetDescription insert, net;
    write_motion(insert, line_of(cell), cell.cell.arms.at("arm").X_FT, "asked.value");
    insert.add("asked", "Or", {{"b", false}});
    RuntimeCommand sensors = line_command(cell, "unused");
    sensors.on_entered(cell.hard(), cancel(sensors));
    for (const auto& p : net_of(sensors).primitives) {
      if (p.id.starts_with("sensor-") || p.id.starts_with("state-") || p.id == "norm" || p.id == "greater_than" ||
          p.type == "WrenchComponents") {
        net.primitives.push_back(p);
      }
    }
    const auto is_kept = [kept = net.primitives](const std::string& port) {
      return std::ranges::any_of(kept, [&](const auto& p) { return port.starts_with(p.id + "."); });
    };
    for (const auto& l : net_of(sensors).links) {
      if (is_kept(l.from) && is_kept(l.to)) net.links.push_back(l);
    }
    net.add("cancel", "Cancel").add("hard", "SetResetLatch", {{"reset", false}}).link("greater_than.value", "hard.set");
    net.add("stop", "Or").link("cancel.requested", "stop.a").link("hard.value", "stop.b");
    net.fragments.push_back(
        {"insert", net::WhenInactive::kReset, insert, {{"cancel", "asked.a"}}, {{"end", "over.value"}}});
    net.link("stop.value", "insert.cancel");
    net.add("inserted", "SetResetLatch", {{"reset", false}}).link("insert.end", "inserted.set");
    net.primitives.back().on_null["set"] = false;
    net.add("inserting", "Not").link_delayed("inserted.value", "inserting.input", false);
    net.link("inserting.value", "insert.active");
    net.add("free", "Not").link("inserting.value", "free.input");
    net.add("button", "DigitalInput", {{"device", "button"}});
    net::FragmentDescription keep, turn;
    keep.id = "keep";
    keep.net.add("state", "ArmState", {{"device", "arm"}}).add("there", "SnapshotJoints", {{"trigger", true}});
    keep.net.link("state.set_point_q", "there.input");
    const Json zero = Json::array({0, 0, 0, 0, 0, 0, 0});
    keep.net.add("robot", "ArmCommand", {{"device", "arm"}, {"dq", zero}, {"ddq", zero}})
        .link("there.value", "robot.q");
    turn.id = "turn";
    turn.net.add("output", "DigitalOutput", {{"device", "driver"}, {"value", true}});
    net.fragments.push_back(keep);
    net.fragments.push_back(turn);
    net.link("free.value", "keep.active").link("inserted.value", "turn.active");
    net.add("released", "And").link("button.value", "released.a").link("free.value", "released.b");
    net.add("end", "Termination").link("released.value", "end.condition");
    return net;
  };
  const Maker mapped = [](CommandCell& cell) { return net_of(screwing(cell)); };
  EXPECT_EQ(run_net(mapped, meanwhile), run_net(by_hand, meanwhile));
}

TEST(Mapping, EveryNetReadsBackFromItsJson) {
  CommandCell cell;
  const NetDescription net = net_of(screwing(cell));
  const auto again = net::net_from_json(Json::parse(net::net_to_json(net).dump()));
  ASSERT_TRUE(again.has_value()) << again.error().to_string();
  EXPECT_EQ(*again, net);
}

// -- When handlers act
// -------------------------------------------------------------------------------------------------

/// The certified cycles from a source to the arm of command "move".
std::pair<std::int64_t, std::int64_t> certified(const CommandCell& cell, rcc::NetId net, const std::string& source) {
  for (const auto& reaction : cell.core.net(net)->report().reactions) {
    if (reaction.source == source && reaction.sink == "move/arm.q") {
      return {reaction.minimum_cycles, reaction.maximum_cycles};
    }
  }
  ADD_FAILURE() << "no reaction of the arm to " << source;
  return {-1, -1};
}

TEST(Mapping, O7_EventToTheFirstBrakingSetPointIsTheCertificate) {
  Random random(7);
  for (int i = 0; i < 20; ++i) {
    CommandCell cell;
    RuntimeCommand move = line_command(cell, "move");
    move.on_entered(cell.hard(), cancel(move));
    const auto net = *cell.core.load(net_of(move));
    const auto [least, most] = certified(cell, net, "sensor-wrist-raw");
    EXPECT_EQ(least, 0);
    EXPECT_EQ(most, 0) << "a sensor's event acts in the same cycle";
    cell.core.start(net);
    cell.step(static_cast<int>(50 + random.uniform(0.0, 300.0)));
    const auto* rate = cell.core.net(net)->find<net::Real>("move/clock.rate");
    ASSERT_EQ(rate->value, 1.0);
    cell.extra.force.y() = -7.0;
    cell.step();
    EXPECT_LT(rate->value, 1.0);
  }
}

TEST(Mapping, O7_AnActionsEventOnItselfIsOneCycleLate) {
  CommandCell cell;
  RuntimeCommand move = line_command(cell, "move");
  move.on_entered(move.action().at_path(0.4), cancel(move));
  const auto net = *cell.core.load(net_of(move));
  cell.core.start(net);
  const auto* s = cell.core.net(net)->find<net::Real>("move/law.s");
  const auto* rate = cell.core.net(net)->find<net::Real>("move/clock.rate");
  while (s->null || s->value < 0.4) {
    cell.step();
    ASSERT_EQ(rate->value, cell.core.state(net) == NetState::kRunning && !rate->null ? 1.0 : rate->value);
    ASSERT_LT(cell.core.cycle(), 5000);
  }
  EXPECT_EQ(rate->value, 1.0) << "the cycle of the event";
  cell.step();
  EXPECT_LT(rate->value, 1.0) << "one cycle later";
  for (int i = 0; i < 2000 && cell.core.state(net) != NetState::kTerminated; ++i) cell.step();
  EXPECT_EQ(cell.core.status(net).cause.code, Cause::Code::kTerminated);
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

/// Core cycle in which the driver was turned on for the first time, from the start on.
int cycles_until_on(CommandCell& cell, LoadedCommand& handle) {
  handle.start();
  for (int i = 0; i < 2000; ++i) {
    cell.runtime.step();
    if (cell.cell.digital_outputs.at("driver")->value()) return i;
  }
  return -1;
}

class HandlerTest : public testing::Test {
 protected:
  LoadedCommand load(const Command& command) {
    auto handle = cell.runtime.load(command);
    if (!handle) ADD_FAILURE() << handle.error().to_string();
    return handle.value();
  }
  RuntimeCommand on(const std::string& name = "on") const { return {name, cell.driver(), set_value(true)}; }
  RuntimeCommand light(bool value = true) const { return {"light", cell.lamp(), set_value(value)}; }
  expression::State button() const { return expression::digital_input(cell.cell, "button"); }
  bool lamp() const { return cell.cell.digital_outputs.at("lamp")->value(); }
  bool driver() const { return cell.cell.digital_outputs.at("driver")->value(); }
  void press(bool down, int cycles = 1) {
    cell.button->sample.value = down;
    for (int i = 0; i < cycles; ++i) cell.runtime.step();
  }
  CommandCell cell;
};

TEST_F(HandlerTest, AWaitLastsAsLongAsItSays) {
  for (const double seconds : {0.0, 0.001, 0.05}) {
    LoadedCommand handle = load(WaitCommand("wait", seconds));
    handle.start();
    EXPECT_TRUE(handle.wait(200).succeeded());
    EXPECT_EQ(handle.status().last_cycle - handle.status().first_cycle, std::llround(seconds * 1000));
  }
}

TEST_F(HandlerTest, ADelayedStartIsDueSoManyCyclesLater) {
  const WaitCommand wait("wait", 0.02);
  const RuntimeCommand later = on();
  TransactionCommand both("both");
  both.add_started(wait).add(later).on_entered(wait.completed(), start(later), {.delay = 0.03});
  LoadedCommand handle = load(both);
  EXPECT_EQ(cycles_until_on(cell, handle), 1 + 20 + 30);
  EXPECT_TRUE(handle.wait(100).succeeded());
}

TEST_F(HandlerTest, LeavingAStateIsAnEventOnlyAfterItHeld) {
  WaitCommand wait("wait", 1.0);
  wait.on_left(button(), cancel(wait));
  LoadedCommand handle = load(wait);
  handle.start();
  press(false, 20);
  EXPECT_FALSE(handle.status().ended()) << "it has never held";
  press(true, 20);
  EXPECT_FALSE(handle.status().ended());
  press(false);
  EXPECT_TRUE(handle.status().succeeded());
}

TEST_F(HandlerTest, AWaitThatTimesOutIsNotCompleted) {
  for (const bool in_time : {false, true}) {
    SCOPED_TRACE(in_time);
    CommandCell own;
    WaitCommand wait("wait", expression::digital_input(own.cell, "button"), 0.05);
    const RuntimeCommand weld("weld", own.driver(), set_value(true)), alarm("alarm", own.lamp(), set_value(true));
    TransactionCommand both("both");
    both.add_started(wait).add(weld).add(alarm);
    both.on_entered(wait.completed(), start(weld)).on_entered(wait.timed_out(), start(alarm));
    auto loaded = own.runtime.load(both);
    ASSERT_TRUE(loaded) << loaded.error().to_string();
    loaded->start();
    for (int i = 0; i < 20; ++i) own.runtime.step();
    own.button->sample.value = in_time;
    EXPECT_EQ(loaded->wait(300).succeeded(), in_time) << loaded->status().to_string();
    EXPECT_EQ(own.cell.digital_outputs.at("driver")->value(), in_time);
    EXPECT_EQ(own.cell.digital_outputs.at("lamp")->value(), !in_time);
  }
}

TEST_F(HandlerTest, N3_AWaitForADeadSensorTimesOut) {
  WaitCommand wait("wait", expression::is_greater(expression::norm(expression::force(cell.felt())), 900.0), 0.05);
  wait.observe("completed", expression::BooleanSensor(wait.completed().node()));
  wait.observe("timed out", expression::BooleanSensor(wait.timed_out().node()));
  cell.sensor->silent = true;
  LoadedCommand handle = load(wait);
  handle.start();
  EXPECT_EQ(handle.wait(300).state, activity::RunState::kFailed);
  EXPECT_EQ(handle.value<bool>("completed"), false);
  EXPECT_EQ(handle.value<bool>("timed out"), true);
}

TEST_F(HandlerTest, AWaitThatIsCancelledIsCompletedAndHasNotTimedOut) {
  WaitCommand wait("wait", button(), 5.0);
  wait.observe("completed", expression::BooleanSensor(wait.completed().node()));
  wait.observe("timed out", expression::BooleanSensor(wait.timed_out().node()));
  LoadedCommand handle = load(wait);
  handle.start();
  press(false, 10);
  handle.cancel();
  EXPECT_EQ(handle.wait(100).state, activity::RunState::kCancelled);
  EXPECT_EQ(handle.value<bool>("completed"), true);
  EXPECT_EQ(handle.value<bool>("timed out"), false);
}

TEST_F(HandlerTest, N3_ADeadSensorCancelsAndDoesNotStart) {
  WaitCommand wait("wait", 5.0), other("other", 5.0);
  const RuntimeCommand started = on();
  wait.on_entered(button(), cancel(wait));
  TransactionCommand both("both");
  both.add_started(wait).add_started(other).add(started).on_entered(button() && other.active(), start(started));
  both.on_entered(wait.completed(), cancel(other));
  LoadedCommand handle = load(both);
  handle.start();
  press(false, 10);
  cell.button->silent = true;
  EXPECT_TRUE(handle.wait(100).succeeded()) << "the guard is not switched off";
  EXPECT_FALSE(driver()) << "and nothing begins because nobody knows";
}

TEST_F(HandlerTest, ARaisedStateIsHeardByOthers) {
  WaitCommand wait("wait", 5.0), other("other", 5.0);
  TransactionCommand both("both");
  const RaisedState alarm = both.raised("alarm");
  wait.on_entered(button(), raise(alarm));
  both.add_started(wait).add_started(other).on_entered(alarm.state(), cancel(both));
  LoadedCommand handle = load(both);
  handle.start();
  press(false, 20);
  EXPECT_FALSE(handle.status().ended());
  press(true, 2);
  EXPECT_TRUE(handle.status().succeeded());
}

TEST_F(HandlerTest, C3_StoppingATransactionStopsAllInsideInTheSameCycle) {
  WaitCommand first("first", 5.0), second("second", 5.0);
  const RuntimeCommand never = on();
  TransactionCommand inner("inner"), outer("outer");
  inner.add_started(first).add_started(second).add(never).on_entered(first.completed(), start(never));
  inner.observe("first", expression::BooleanSensor(first.active().node()));
  inner.observe("second", expression::BooleanSensor(second.active().node()));
  const WaitCommand rest("rest", 0.1);
  outer.add_started(inner).add_started(rest).on_entered(button(), stop(inner));
  LoadedCommand handle = load(outer);
  handle.start();
  press(false, 20);
  EXPECT_EQ(handle.value<bool>("first"), true);
  press(true);
  EXPECT_EQ(handle.value<bool>("first"), false);
  EXPECT_EQ(handle.value<bool>("second"), false);
  EXPECT_TRUE(handle.wait(200).succeeded()) << "what is beside it goes on";
  EXPECT_FALSE(driver()) << "stopped is not completed";
}

TEST_F(HandlerTest, C4_CancelIsForwardedAndNothingElseStarts) {
  const WaitCommand wait("wait", 5.0);
  const RuntimeCommand never = on();
  TransactionCommand both("both");
  both.add_started(wait).add(never).on_entered(wait.completed(), start(never));
  LoadedCommand handle = load(both);
  handle.start();
  press(false, 20);
  handle.cancel();
  EXPECT_EQ(handle.wait(10).cause.code, Cause::Code::kCancelled);
  EXPECT_FALSE(driver());
}

TEST_F(HandlerTest, C4_ATransactionSaysWhatCancelDoes) {
  const WaitCommand told("told", 5.0), untold("untold", 0.1);
  const RuntimeCommand clean_up = on();
  TransactionCommand three("three");
  three.add_started(told).add_started(untold).add(clean_up).on_cancel_forward_to({told});
  three.on_entered(three.cancelled(), start(clean_up));
  LoadedCommand handle = load(three);
  handle.start();
  press(false, 20);
  handle.cancel();
  EXPECT_TRUE(handle.wait(300).succeeded());
  EXPECT_EQ(handle.status().last_cycle - handle.status().first_cycle, 100) << "untold went on to its end";
  EXPECT_TRUE(driver()) << "its own handler ran";
}

TEST_F(HandlerTest, C4_ATransactionMayIgnoreCancel) {
  const WaitCommand wait("wait", 0.1);
  const RuntimeCommand then = on();
  TransactionCommand both("both");
  both.add_started(wait).add(then).on_cancel_ignore().on_entered(wait.completed(), start(then));
  LoadedCommand handle = load(both);
  handle.start();
  press(false, 20);
  handle.cancel();
  EXPECT_TRUE(handle.wait(300).succeeded());
  EXPECT_TRUE(driver());
}

TEST_F(HandlerTest, C7_O4_AConflictWhileRunningStopsTheArmWithTheCause) {
  const RuntimeCommand a = line_command(cell, "a");
  const RuntimeCommand b("b", cell.arm_actuator(), hold());
  TransactionCommand both("both");
  both.add_started(a).add(b).on_entered(button(), start(b));
  LoadedCommand handle = load(both);
  handle.start();
  press(false, 200);
  press(true);
  const CommandStatus status = handle.wait(10);
  EXPECT_EQ(status.cause.code, Cause::Code::kConflict) << status.to_string();
  EXPECT_THAT(std::string(status.cause.text.view()), takt::test::Names("a", "b"));
  cell.step(2000);
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

TEST_F(HandlerTest, C7_WhoComesWhenTheArmIsFreeIsNoConflict) {
  const RuntimeCommand a = line_command(cell, "a");
  const RuntimeCommand b("b", cell.arm_actuator(), hold());
  TransactionCommand both("both");
  both.add_started(a).add(b).on_entered(button() && a.completed(), start(b)).on_left(button(), cancel(b));
  LoadedCommand handle = load(both);
  handle.start();
  press(true, 2000);
  EXPECT_TRUE(cell.core_arm().at_rest());
  EXPECT_FALSE(handle.status().ended()) << "the arm is held";
  press(false, 2);
  EXPECT_TRUE(handle.status().succeeded()) << handle.status().to_string();
}

TEST_F(HandlerTest, ActuatorsSayWhenTheyHaveArrived) {
  const RuntimeCommand a = line_command(cell, "a");
  EXPECT_EQ(a.actuator().completed().now(), true);
  EXPECT_EQ(a.actuator().emergency_stop().now(), false);
  LoadedCommand handle = load(a);
  handle.start();
  press(false, 200);
  EXPECT_EQ(a.actuator().completed().now(), false) << "it moves";
  EXPECT_TRUE(handle.wait().succeeded());
  cell.step(2);
  EXPECT_EQ(a.actuator().completed().now(), true);
  cell.backend->state().ready = false;
  cell.step();
  EXPECT_EQ(a.actuator().emergency_stop().now(), true);
}

TEST_F(HandlerTest, N4_ASetPointThatIsNoneIsToldOutside) {
  std::vector<ExternalEvent> told;
  RuntimeCommand valve("valve", output(cell.cell, "valve"),
                       follow_value(expression::analog_output(cell.cell, "valve") / 0.0));
  valve.on_entered(valve.actuator().invalid_set_point(),
                   external("invalid", [&told](const ExternalEvent& event) { told.push_back(event); }));
  LoadedCommand handle = load(valve);
  handle.start();
  const CommandStatus status = handle.wait(10);
  EXPECT_EQ(status.cause.code, Cause::Code::kNullInput) << status.to_string();
  ASSERT_EQ(told.size(), 1u);
}

TEST_F(HandlerTest, P2_SpeedIsAChannel) {
  const auto speed = channel<net::Real>(cell.cell, "speed");
  RuntimeCommand move("move", cell.arm_actuator(),
                      ptp(cell.joints(0.3), {.velocity = 0.5, .clock = {.speed = speed, .pause = {}}}));
  LoadedCommand handle = load(move);
  handle.start();
  const auto* rate = cell.core.net(handle.net())->find<net::Real>("move/clock.rate");
  press(false, 100);
  EXPECT_EQ(rate->value, 1.0);
  cell.cell.channels.at("speed")->write(0.25);
  press(false, 300);
  EXPECT_NEAR(rate->value, 0.25, 1e-9);
  cell.cell.channels.at("speed")->write_null();
  press(false, 300);
  EXPECT_EQ(rate->value, 0.0) << "nobody says how fast";
  cell.cell.channels.at("speed")->write(1.0);
  EXPECT_TRUE(handle.wait().succeeded());
  EXPECT_LE(cell.worst_limit_share(), 1.0);
}

}  // namespace
}  // namespace takt::command
