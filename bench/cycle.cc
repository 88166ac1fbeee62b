// Work of the control core per arm and cycle: a LIN net with inverse kinematics on an LWR 4+ (a perfect follower),
// guard included; and what the digest adds. Prints percentiles over the cycles of many runs, in microseconds.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "core/device/device_file.h"
#include "core/kinematics/chain.h"
#include "core/motion/path_clock.h"
#include "core/motion/planner.h"
#include "core/rcc/admission.h"
#include "core/rcc/control_core.h"
#include "tests/support/fake_arm.h"

namespace takt {
namespace {

constexpr int kRuns = 40;

net::NetDescription lin_net(const std::string& arm, const motion::Motion& motion) {
  net::NetDescription net;
  net.name = "lin";
  net.add("cancel", "Cancel").add("target", "SelectReal", {{"if_true", 0.0}, {"if_false", 1.0}});
  net.add("clock", "PathClock", {{"bounds", motion::to_json(motion.clock)}, {"duration", motion.duration()}});
  net.add("law", "TimeLaw", {{"law", motion::to_json(motion.law)}});
  net.add("line", "CartesianLine", {{"path", motion::to_json(motion.path)}});
  net.add("ik", "InverseKinematics", {{"device", arm}}).add("arm", "ArmCommand", {{"device", arm}});
  net.add("end", "Termination");
  net.link("cancel.requested", "target.condition").link("target.value", "clock.target_rate");
  const auto join = [&net](const char* from, const char* to, std::initializer_list<const char*> ports) {
    for (const char* port : ports) net.link(std::string(from) + "." + port, std::string(to) + "." + port);
  };
  join("clock", "law", {"time", "rate", "rate_derivative"});
  join("law", "line", {"s", "ds", "dds"});
  join("line", "ik", {"frame", "twist", "acceleration", "held", "held_velocity", "held_acceleration"});
  join("ik", "arm", {"q", "dq", "ddq"});
  net.link("clock.at_end", "end.condition");
  return net;
}

struct Sample {
  std::vector<double> cycle_us;
  std::array<double, rcc::kCyclePhases> phase_us{};
};

/// Runs the motion with `arm_count` arms in step.
Sample measure(const std::shared_ptr<const device::ArmDescription>& model, const motion::Motion& motion, int arm_count,
               bool digest, bool phases) {
  Sample sample;
  std::int64_t cycles = 0;
  for (int run = 0; run < kRuns; ++run) {
    rcc::ControlCore core({.digest = digest, .measure = phases});
    rcc::Transaction start;
    for (int i = 0; i < arm_count; ++i) {
      auto backend = std::make_shared<test::FakeArm>(model->home);
      backend->keep = false;
      core.add(std::make_unique<device::Arm>(fmt::format("arm{}", i), model, std::move(backend), core.period()));
    }
    for (int i = 0; i < arm_count; ++i)
      (void)start.start.add(core.load(lin_net(fmt::format("arm{}", i), motion)).value());
    core.step();
    (void)core.post(start);
    core.step();
    const rcc::NetId last = *(start.start.end() - 1);
    while (core.state(last) == rcc::NetState::kRunning) {
      const auto before = std::chrono::steady_clock::now();
      core.step();
      const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - before;
      sample.cycle_us.push_back(spent.count() / arm_count);
    }
    const auto& statistics = core.statistics();
    cycles += statistics.measured_cycles;
    for (int p = 0; p < rcc::kCyclePhases; ++p)
      sample.phase_us[static_cast<std::size_t>(p)] +=
          1e-3 * static_cast<double>(statistics.phase_ns[static_cast<std::size_t>(p)]) / arm_count;
  }
  for (double& phase : sample.phase_us) phase /= static_cast<double>(std::max<std::int64_t>(cycles, 1));
  std::ranges::sort(sample.cycle_us);
  return sample;
}

double percentile(const Sample& sample, double share) {
  return sample.cycle_us[static_cast<std::size_t>(share * static_cast<double>(sample.cycle_us.size() - 1))];
}

void print(const char* name, const Sample& sample) {
  fmt::print("{:<44} p50 {:6.3f}  p90 {:6.3f}  p99 {:6.3f}  p99.9 {:6.3f}  max {:7.3f} us/arm/cycle\n", name,
             percentile(sample, 0.5), percentile(sample, 0.9), percentile(sample, 0.99), percentile(sample, 0.999),
             percentile(sample, 1.0));
}

/// Median time of a step in ns.
double median_step_ns(rcc::ControlCore& core, const std::function<void(std::int64_t)>& before) {
  std::vector<double> ns;
  for (std::int64_t k = 0; k < 20'000; ++k) {
    before(k);
    const auto begin = std::chrono::steady_clock::now();
    core.step();
    ns.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count());
  }
  std::ranges::nth_element(ns, ns.begin() + 10'000);
  return ns[10'000];
}

enum class ChannelUse { kIdle, kLatched, kRead, kWritten, kWatched };

/// What channels (poses, the widest values) add to a cycle, one by one.
double channels_ns(int count, ChannelUse use, bool digest) {
  using device::ChannelDescription;
  const bool by_net = use == ChannelUse::kWritten;
  rcc::ControlCore core({.digest = digest});
  net::NetDescription net;
  net.name = "channels";
  net.add("end", "Termination", {{"condition", false}});
  std::vector<device::Channel*> channels;
  std::vector<std::shared_ptr<rcc::Watch>> watches;
  for (int i = 0; i < count; ++i) {
    const std::string name = fmt::format("c{}", i);
    channels.push_back(
        *core.declare({.name = name,
                       .type = net::ValueType::kFrame,
                       .writer = by_net ? ChannelDescription::Writer::kNet : ChannelDescription::Writer::kOutside,
                       .initial = net::Frame::Identity()}));
    if (use == ChannelUse::kRead) net.add("in" + name, "InputFrame", {{"channel", name}});
    if (!by_net) continue;
    net.add("out" + name, "OutputFrame", {{"channel", name}, {"value", nullptr}});
  }
  core.start(core.load(net).value());
  if (use == ChannelUse::kWatched)
    for (const device::Channel* channel : channels)
      watches.push_back(core.watch(channel->name(), {.every = 1, .capacity = 1'000'000}).value());
  for (int i = 0; i < 2; ++i) core.step();
  return median_step_ns(core, [&](std::int64_t) {
    if (use != ChannelUse::kLatched) return;
    for (device::Channel* channel : channels) (void)channel->write(net::Frame::Identity());
  });
}

void print_channels() {
  constexpr int kCount = 50;
  fmt::print(
      "channels and monitors of type Frame, ns each and cycle (mean over {}, median cycle), without / with digest\n",
      kCount);
  const auto each = [](ChannelUse use, bool digest) {
    return (channels_ns(kCount, use, digest) - channels_ns(0, ChannelUse::kIdle, digest)) / kCount;
  };
  for (const auto& [name, use] : {std::pair{"channel at rest", ChannelUse::kIdle},
                                  {"value from outside taken in", ChannelUse::kLatched},
                                  {"read by a net", ChannelUse::kRead},
                                  {"written by a net", ChannelUse::kWritten},
                                  {"watched, all values and the newest", ChannelUse::kWatched}})
    fmt::print("  {:<40} {:6.1f} / {:6.1f}\n", name, each(use, false), each(use, true));
}

/// What LOAD takes the net of a motion for, against what it takes.
void print_estimate(const std::shared_ptr<const device::ArmDescription>& model, const motion::Motion& motion) {
  rcc::ControlCore core({});
  core.add(std::make_unique<device::Arm>("arm0", model, std::make_shared<test::FakeArm>(model->home), core.period()));
  const auto estimate = core.status(core.load(lin_net("arm0", motion)).value()).cost_ns;
  const auto phases = measure(model, motion, 1, false, true);
  fmt::print("the LIN net: estimated {:.2f} us, measured {:.2f} us a cycle\n", 1e-3 * estimate,
             phases.phase_us[static_cast<std::size_t>(rcc::CyclePhase::kNets)]);
}

int run() {
  const auto model = device::read_arm("models/lwr4plus");
  if (!model) {
    fmt::print(stderr, "{}", model.error().to_string());
    return 2;
  }
  Eigen::Isometry3d goal = (*model)->chain->forward((*model)->home);
  goal.translation() += Eigen::Vector3d(0.05, 0.1, -0.15);
  const auto motion = motion::plan_lin(*(*model)->chain, *(*model)->inverse, (*model)->limits, (*model)->cartesian,
                                       (*model)->home, goal);
  if (!motion) {
    fmt::print(stderr, "{}", motion.error().to_string());
    return 2;
  }
  fmt::print("LIN net with inverse kinematics, guard, LWR 4+; {} runs of {:.2f} s\n", kRuns, motion->duration());
  print("one arm, no digest (target 2.5)", measure(*model, *motion, 1, false, false));
  print("one arm, digest (target 0.5 more)", measure(*model, *motion, 1, true, false));
  print("eight arms, no digest", measure(*model, *motion, 8, false, false));
  print("eight arms, digest", measure(*model, *motion, 8, true, false));
  const Sample phases = measure(*model, *motion, 8, true, true);
  fmt::print("phases with eight arms, mean us/arm/cycle:");
  for (int p = 0; p < rcc::kCyclePhases; ++p)
    fmt::print("  {} {:.3f}", rcc::name_of(static_cast<rcc::CyclePhase>(p)),
               phases.phase_us[static_cast<std::size_t>(p)]);
  fmt::print("\n");
  print_channels();
  fmt::print("this machine against the reference of cost estimates: {:.2f}\n", rcc::machine_factor());
  print_estimate(*model, *motion);
  return 0;
}

}  // namespace
}  // namespace takt

int main() { return takt::run(); }
