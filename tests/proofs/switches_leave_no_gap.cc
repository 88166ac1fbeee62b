// Rows L2, L3, L5, L7, S2 over random switches: nets on four arms are started, cancelled, aborted, scheduled after each
// other, exchanged in transactions, in random cycles, rightly and wrongly. In every cycle every arm gets exactly one
// set point, at most one net holds it, and what it gets keeps the limits.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/motion/path_clock.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "tests/core/rcc/fixture.h"
#include "tests/support/random_runs.h"

namespace takt::test {
namespace {

using rcc::NetId;
using rcc::NetState;

constexpr int kArms = 4;
constexpr double kPositionError = 1e-11;

/// Throws in one cycle.
class ProofThrow final : public net::Primitive {
 public:
  explicit ProofThrow(net::Setup& setup) : at_(setup.parameter<net::Integer>("at", {.doc = "when"})) {}
  void update(const net::Cycle& cycle) override {
    if (cycle.index_in_net == at_) throw std::runtime_error("on purpose");
  }

 private:
  net::Integer at_;
};
TAKT_PRIMITIVE(ProofThrow, "test", "Throws.");

/// An arm that is where it was sent, and judges every cycle of its life.
class JudgedArm final : public device::ArmBackend {
 public:
  explicit JudgedArm(const motion::JointLimits& limits)
      : oracle({list(limits.lower), list(limits.upper), list(limits.velocity), list(limits.acceleration),
                list(limits.jerk)},
               1e-3, kPositionError) {}

  bool read(device::ArmSample& sample) override {
    sample.sequence = ++sequence_;
    sample.stamp = now_;
    sample.q = q;
    sample.dq = JointVector::Zero(kFakeJoints);
    sample.ready = true;
    return true;
  }
  void write(const device::ArmSetPoint& set_point) override {
    now_ = set_point.stamp + kMillisecond;
    if (last_cycle >= 0 && set_point.cycle > last_cycle + 1) gaps += set_point.cycle - last_cycle - 1;
    if (last_cycle >= 0 && set_point.cycle <= last_cycle) ++doubles;
    last_cycle = set_point.cycle;
    q = set_point.q;
    fresh = true;
  }
  /// Looks at what the last cycle sent; outside of it, since this allocates.
  void judge() {
    if (!std::exchange(fresh, false)) return;
    oracle.add(list(q));
    if (keep) sent.push_back(q);
  }
  void set_payload(const device::PayloadSetting&) override {}
  void brake() override {}
  [[nodiscard]] std::string fault_text(std::uint32_t) const override { return {}; }

  JointVector q = JointVector::Zero(kFakeJoints);
  std::int64_t last_cycle = -1, gaps = 0, doubles = 0;
  LimitOracle oracle;
  bool keep = false;
  bool fresh = false;
  std::vector<JointVector> sent;

 private:
  static std::vector<double> list(const JointVector& v) { return {v.begin(), v.end()}; }
  std::uint64_t sequence_ = 0;
  Nanoseconds now_ = 0;
};

std::string arm_name(int arm) { return "arm" + std::to_string(arm); }

struct Way {
  int arm;
  JointVector start, goal;
};

/// One clock and one law for the arms of a net, a line and a command for each.
NetDescription group_net(const std::vector<Way>& ways) {
  double longest = 0.0;
  for (const Way& way : ways) longest = std::max(longest, (way.goal - way.start).cwiseAbs().maxCoeff());
  const auto law =
      motion::TimeLaw::rest_to_rest({.velocity = 0.8 / longest, .acceleration = 2.0 / longest, .jerk = 40.0 / longest});
  const motion::ClockBounds bounds{.acceleration_max = 4.0, .jerk_max = 80.0};
  NetDescription net;
  net.add("cancel", "Cancel").add("target", "SelectReal", {{"if_true", 0.0}, {"if_false", 1.0}});
  net.add("clock", "PathClock", {{"bounds", motion::to_json(bounds)}, {"duration", law.duration()}});
  net.add("law", "TimeLaw", {{"law", motion::to_json(law)}});
  net.add("stopped", "And").add("over", "Or").add("end", "Termination");
  net.link("cancel.requested", "target.condition").link("target.value", "clock.target_rate");
  for (const char* port : {"time", "rate", "rate_derivative"})
    net.link(std::string("clock.") + port, std::string("law.") + port);
  for (const Way& way : ways) {
    const std::string line = "line" + std::to_string(way.arm), arm = arm_name(way.arm);
    net.add(line, "JointLine", {{"path", motion::to_json(motion::Path(motion::JointLine{way.start, way.goal}))}});
    net.add(arm, "ArmCommand", {{"device", arm}});
    for (const char* port : {"s", "ds", "dds"}) net.link(std::string("law.") + port, line + "." + port);
    for (const char* port : {"q", "dq", "ddq"}) net.link(line + "." + port, arm + "." + port);
  }
  net.link("cancel.requested", "stopped.a").link("clock.standstill", "stopped.b");
  net.link("clock.at_end", "over.a").link("stopped.value", "over.b").link("over.value", "end.condition");
  return net;
}

/// A core with four judged arms.
struct Cell {
  Cell() : description(std::make_shared<const device::ArmDescription>(fake_arm_description(kFakeJoints))) {
    for (int i = 0; i < kArms; ++i) {
      backends.push_back(std::make_shared<JudgedArm>(description->limits));
      core.add(std::make_unique<device::Arm>(arm_name(i), description, backends.back(), core.period()));
    }
    step();
  }
  void step() {
    guarded_step(core);
    judge();
  }
  /// A cycle in which something is thrown; what is thrown lies on the heap.
  void throwing_step() {
    core.step();
    judge();
  }
  std::shared_ptr<const device::ArmDescription> description;
  void judge() {
    for (const auto& backend : backends) backend->judge();
  }
  std::vector<std::shared_ptr<JudgedArm>> backends;
  rcc::ControlCore core{{.digest = false}};
};

/// Asks for things at random and knows which net wants which arms.
class Operator {
 public:
  Operator(Cell& cell, Random& random) : cell_(cell), random_(random) {}

  void act() {
    const double what = random_.unit();
    if (what < 0.45) {
      cell_.core.start(new_net(from_rest()));
    } else if (what < 0.60) {
      if (const NetId id = any_active()) schedule_after(id);
    } else if (what < 0.72) {
      if (const NetId id = any_active()) cell_.core.cancel(id);
    } else if (what < 0.82) {
      if (const NetId id = any_active()) cell_.core.abort(id);
    } else if (what < 0.90) {
      exchange();
    } else if (what < 0.96) {
      if (const NetId id = any_active()) cancel_at_the_end_of(id);
    } else if (what < 0.995) {
      cell_.core.start(1 + random_.bits() % 100'000);  // loaded or not, ended or running
    } else {
      cell_.core.stop_all(net::Cause::Code::kAborted, "everything");
    }
  }

  /// After a step: counts switches, checks that an arm has one holder, forgets what has ended.
  void look() {
    for (const rcc::Event& event : cell_.core.events()) {
      if (event.kind == rcc::Event::Kind::kRefused) ++refused;
      if (event.kind == rcc::Event::Kind::kStopped) ++stops;
      if (event.kind != rcc::Event::Kind::kState || !nets_.contains(event.net)) continue;
      if (event.state == NetState::kRunning || event.state == NetState::kTerminated)
        switches += static_cast<long>(nets_.at(event.net).size());
      if (event.state == NetState::kTerminated) ended_.push_back(event.net);
    }
    std::array<int, kArms> holders{};
    for (const auto& [id, ways] : nets_) {
      const NetState state = cell_.core.state(id);
      if (state != NetState::kRunning && state != NetState::kCanceling) continue;
      for (const Way& way : ways) ++holders[static_cast<std::size_t>(way.arm)];
    }
    for (const int count : holders) double_holders += count > 1 ? 1 : 0;
    check_successors();
    forget();
  }

  long switches = 0, refused = 0, stops = 0, double_holders = 0, successors = 0, late_successors = 0;

 private:
  /// A few arms and where they shall go; mostly from where they stand.
  std::vector<Way> from_rest() {
    std::vector<Way> ways;
    const int first = static_cast<int>(random_.bits() % kArms);
    for (int i = 0; i < (random_.unit() < 0.25 ? 2 : 1); ++i) {
      const int arm = (first + i) % kArms;
      JointVector start = cell_.core.find_arm(arm_name(arm))->set_point().q;
      if (random_.unit() < 0.03) start[1] += random_.uniform(-0.02, 0.02);
      ways.push_back({arm, start, goal_from(start)});
    }
    return ways;
  }
  JointVector goal_from(const JointVector& start) {
    const double size = std::pow(10.0, random_.uniform(-4.0, -1.5));
    JointVector goal = start;
    for (double& q : goal) q = std::clamp(q + size * random_.uniform(-1.0, 1.0), -2.5, 2.5);
    goal[0] += std::abs(goal[0]) < 2.0 ? size : std::copysign(size, -goal[0]);  // never no way at all
    return goal;
  }
  NetId new_net(const std::vector<Way>& ways) {
    const auto id = cell_.core.load(group_net(ways), {.cancel_bound_cycles = 200});
    EXPECT_TRUE(id.has_value()) << (id ? "" : id.error().to_string());
    if (!id) return 0;
    nets_[*id] = ways;
    waiting_.push_back(*id);
    return *id;
  }
  NetId any_active() {
    std::vector<NetId> active;
    for (const auto& [id, ways] : nets_) {
      const NetState state = cell_.core.state(id);
      if (state == NetState::kRunning || state == NetState::kCanceling) active.push_back(id);
    }
    return active.empty() ? 0 : active[random_.bits() % active.size()];
  }
  void schedule_after(NetId before) {
    std::vector<Way> ways = nets_.at(before);
    for (Way& way : ways) {
      way.start = way.goal;
      way.goal = goal_from(way.start);
    }
    const NetId id = new_net(ways);
    (void)cell_.core.post(rcc::Rule{.condition = {rcc::Term::state(before, {NetState::kTerminated})},
                                    .action = {.abort = {}, .cancel = {}, .start = {id}}});
    successors_[id] = before;
  }
  /// One net goes and others come, wholly or not at all.
  void exchange() {
    rcc::Transaction transaction;
    if (const NetId id = any_active()) transaction.abort = {id};
    transaction.start = {new_net(from_rest())};
    if (random_.unit() < 0.5) {
      ASSERT_TRUE(transaction.start.add(new_net(from_rest())));
    }
    (void)cell_.core.post(transaction);
  }
  void cancel_at_the_end_of(NetId id) {
    const auto* at_end = cell_.core.net(id)->find<net::Boolean>("clock.at_end");
    rcc::Transaction transaction;
    if (const NetId other = any_active()) transaction.cancel = {other};
    (void)cell_.core.post(rcc::Rule{.condition = {rcc::Term::output(id, at_end)}, .action = transaction});
  }

  /// Row L3: the first cycle of a successor follows the last of its predecessor.
  void check_successors() {
    std::erase_if(successors_, [this](const auto& pair) {
      const auto [id, before] = pair;
      if (cell_.core.state(id) != NetState::kRunning) return cell_.core.state(before) == NetState::kTerminated;
      // After a stop the arm has to come to rest first, if the start is not refused at all.
      const net::Cause::Code cause = cell_.core.status(before).cause.code;
      if (cause != net::Cause::Code::kTerminated && cause != net::Cause::Code::kCancelled) return true;
      ++successors;
      late_successors += cell_.core.status(id).first_cycle != cell_.core.status(before).last_cycle + 1 ? 1 : 0;
      return true;
    });
  }
  /// What has ended is unloaded some time later; what never started, too.
  void forget() {
    if (++looks_ % 512 != 0) return;
    for (const NetId id : ended_) drop(id);
    ended_.clear();
    std::vector<NetId> young;
    for (const NetId id : waiting_) {
      const bool old = id + 200 < (nets_.empty() ? 0 : nets_.rbegin()->first);
      if (!old) young.push_back(id);
      if (old && nets_.contains(id) && cell_.core.state(id) == NetState::kReady) drop(id);
    }
    waiting_ = young;
  }
  void drop(NetId id) {
    cell_.core.unload(id);
    nets_.erase(id);
    successors_.erase(id);
    std::erase_if(successors_, [id](const auto& pair) { return pair.second == id; });
  }

  Cell& cell_;
  Random& random_;
  std::map<NetId, std::vector<Way>> nets_;
  std::map<NetId, NetId> successors_;
  std::vector<NetId> ended_, waiting_;
  long looks_ = 0;
};

TEST(Switches, RowsL2L3L5LeaveNoGapNoDoubleAndNoLimit) {
  const RandomRuns runs(100'000);
  Random random(runs.first_seed, "switches");
  Cell cell;
  Operator person(cell, random);
  while (person.switches < runs.count) {
    if (random.unit() < 0.2) person.act();
    cell.step();
    person.look();
    for (const auto& arm : cell.backends) ASSERT_EQ(arm->last_cycle, cell.core.cycle() - 1) << "an empty cycle";
  }
  double velocity = 0.0, acceleration = 0.0, jerk = 0.0;
  for (const auto& arm : cell.backends) {
    EXPECT_EQ(arm->gaps, 0);
    EXPECT_EQ(arm->doubles, 0);
    EXPECT_LE(arm->oracle.range_excess, 0.0);
    velocity = std::max(velocity, arm->oracle.velocity.share);
    acceleration = std::max(acceleration, arm->oracle.acceleration.share);
    jerk = std::max(jerk, arm->oracle.jerk.share);
  }
  EXPECT_LE(std::max({velocity, acceleration, jerk}), 1.0 + device::Guard::kShare);
  EXPECT_EQ(person.double_holders, 0);
  EXPECT_EQ(person.late_successors, 0);
  std::printf(
      "%ld switches in %lld cycles: 0 empty cycles, 0 double writers; %ld successors without a gap, %ld "
      "requests refused, %ld stop reactions; largest share of a limit: velocity %.3f, acceleration %.3f, "
      "jerk %.3f\n",
      person.switches, static_cast<long long>(cell.core.cycle()), person.successors, person.refused, person.stops,
      velocity, acceleration, jerk);
  EXPECT_GT(person.successors, person.switches / 100);
  EXPECT_GT(person.stops, person.switches / 100);
  EXPECT_GT(person.refused, person.switches / 100);
}

/// What all arms are sent while net after net runs on arm 0, and `disturb` does something to others.
template <class Disturb>
std::vector<JointVector> sent_to_first_arm(std::uint64_t seed, Disturb disturb) {
  Random random(seed, "bystander");
  Cell cell;
  cell.backends[0]->keep = true;
  JointVector goal = JointVector::Constant(kFakeJoints, random.uniform(0.01, 0.3));
  const auto id = cell.core.load(group_net({{0, JointVector::Zero(kFakeJoints), goal}}));
  EXPECT_TRUE(id.has_value());
  cell.core.start(*id);
  const int at = 2 + static_cast<int>(random.bits() % 150);
  for (int i = 0; i < 500; ++i) {
    if (i == at) disturb(cell, random);
    cell.step();
  }
  return cell.backends[0]->sent;
}

TEST(Switches, RowL2ASecondClaimOnARunningArmIsRefusedAndMovesNoBit) {
  const RandomRuns runs(300);
  for (long i = 0; i < runs.count; ++i) {
    const std::uint64_t seed = runs.first_seed + static_cast<std::uint64_t>(i);
    long refused = 0;
    const auto alone = sent_to_first_arm(seed, [](Cell&, Random&) {});
    const auto claimed = sent_to_first_arm(seed, [&](Cell& cell, Random& random) {
      const JointVector start = cell.core.find_arm(arm_name(0))->set_point().q;
      const auto id = cell.core.load(
          group_net({{0, start, start + JointVector::Constant(kFakeJoints, random.uniform(0.001, 0.1))}}));
      ASSERT_TRUE(id.has_value());
      cell.core.start(*id);
      cell.step();
      for (const rcc::Event& event : cell.core.events())
        refused += event.kind == rcc::Event::Kind::kRefused && event.net == *id ? 1 : 0;
    });
    ASSERT_EQ(refused, 1) << "seed " << seed;
    ASSERT_TRUE(std::equal(alone.begin(), alone.end(), claimed.begin())) << "seed " << seed;
  }
}

TEST(Switches, RowL7AThrowingPrimitiveMovesNoBitOfOtherNets) {
  const RandomRuns runs(300);
  for (long i = 0; i < runs.count; ++i) {
    const std::uint64_t seed = runs.first_seed + static_cast<std::uint64_t>(i);
    NetId thrower = 0;
    bool stopped = false;
    const auto alone = sent_to_first_arm(seed, [](Cell&, Random&) {});
    const auto beside = sent_to_first_arm(seed, [&](Cell& cell, Random& random) {
      NetDescription net = group_net({{1, JointVector::Zero(kFakeJoints), JointVector::Constant(kFakeJoints, 0.2)},
                                      {2, JointVector::Zero(kFakeJoints), JointVector::Constant(kFakeJoints, -0.1)}});
      const int at = static_cast<int>(random.bits() % 200);
      net.add("bad", "ProofThrow", {{"at", at}});
      const auto id = cell.core.load(net);
      ASSERT_TRUE(id.has_value()) << id.error().to_string();
      thrower = *id;
      cell.core.start(thrower);
      for (int k = 0; k <= at + 1; ++k) cell.throwing_step();
      stopped = cell.core.status(thrower).cause.code == net::Cause::Code::kException;
    });
    ASSERT_TRUE(stopped) << "seed " << seed;
    ASSERT_TRUE(std::equal(alone.begin(), alone.end(), beside.begin())) << "seed " << seed;
  }
}

}  // namespace
}  // namespace takt::test
