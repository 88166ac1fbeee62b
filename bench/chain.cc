// Work for a transaction whose commands follow each other on one device: check and mapping, LOAD with its proof that no
// two of them drive it together (row O4), and a cycle of the net. By the number of commands.
#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/device_action.h"
#include "core/command/actions/motion_action.h"
#include "core/command/mapping.h"
#include "core/device/device_file.h"
#include "core/kinematics/chain.h"
#include "core/rcc/control_core.h"
#include "tests/support/fake_arm.h"
#include "tests/support/fake_signals.h"

namespace takt::command {
namespace {

/// A core with an LWR that is always where it was sent, and an output.
struct Bench {
  Bench() : model(*device::read_arm("models/lwr4plus")), backend(std::make_shared<test::FakeArm>(model->home)) {
    backend->keep = false;
    expression::MountedArm mounted;
    mounted.device = &core.add(std::make_unique<device::Arm>("arm", model, backend, core.period()));
    cell.arms["arm"] = mounted;
    (void)cell.frames.add("arm", "world", Eigen::Isometry3d::Identity());
    cell.digital_outputs["lamp"] = &core.add(std::make_unique<device::DigitalOutput>(
        "lamp", device::SignalOutputDescription<bool>{}, std::make_shared<test::FakeOutput<bool>>(), core.period()));
    core.step();
  }

  std::shared_ptr<const device::ArmDescription> model;
  std::shared_ptr<test::FakeArm> backend;
  rcc::ControlCore core{{}};
  expression::Cell cell;
};

RuntimeCommand set(const Bench& bench, std::int64_t i) {
  return {fmt::format("c{}", i), output(bench.cell, "lamp"), set_value(i % 2 == 0)};
}

/// There and back by a hundredth of a radian.
RuntimeCommand turn(const Bench& bench, std::int64_t i) {
  device::JointVector q = bench.model->home;
  q[0] += i % 2 == 0 ? 0.01 : 0.0;
  return {fmt::format("c{}", i), arm(bench.cell, "arm"), ptp(q)};
}

template <class Make>
TransactionCommand chain(const Bench& bench, std::int64_t count, Make make) {
  TransactionCommand whole("whole");
  std::optional<RuntimeCommand> before;
  for (std::int64_t i = 0; i < count; ++i) {
    RuntimeCommand next = make(bench, i);
    if (before) whole.add(next).on_entered(before->completed() && !before->cancelled(), start(next));
    if (!before) whole.add_started(next);
    before = next;
  }
  return whole;
}

MappedCommand mapped_chain(benchmark::State& state, const TransactionCommand& whole) {
  auto mapped = map(whole);
  if (mapped) return std::move(*mapped);
  state.SkipWithError(mapped.error().to_string().substr(0, 500).c_str());
  return {};
}

template <class Make>
void load(benchmark::State& state, Make make) {
  Bench bench;
  const TransactionCommand whole = chain(bench, state.range(0), make);
  (void)plan(whole);
  const MappedCommand mapped = mapped_chain(state, whole);
  for (auto _ : state) {
    auto net = net::CompiledNet::compile(mapped.net, bench.core.environment());
    if (!net) state.SkipWithError(net.error().to_string().substr(0, 500).c_str());
    benchmark::DoNotOptimize(net);
  }
  state.counters["primitives"] = static_cast<double>(mapped.net.primitives.size());
}

template <class Make>
void check_and_map(benchmark::State& state, Make make) {
  Bench bench;
  const TransactionCommand whole = chain(bench, state.range(0), make);
  (void)plan(whole);
  for (auto _ : state) benchmark::DoNotOptimize(mapped_chain(state, whole));
}

void LoadOfSets(benchmark::State& state) { load(state, set); }
void MappingOfSets(benchmark::State& state) { check_and_map(state, set); }
void LoadOfMotions(benchmark::State& state) { load(state, turn); }
void MappingOfMotions(benchmark::State& state) { check_and_map(state, turn); }

void PlanningOfMotions(benchmark::State& state) {
  Bench bench;
  for (auto _ : state) {
    const Diagnostics wrong = plan(chain(bench, state.range(0), turn));
    if (wrong.has_errors()) state.SkipWithError(wrong.to_string().substr(0, 500).c_str());
  }
}

void CycleOfSets(benchmark::State& state) {
  Bench bench;
  const MappedCommand mapped = mapped_chain(state, chain(bench, state.range(0), set));
  const auto net = net::CompiledNet::compile(mapped.net, bench.core.environment());
  if (!net) return state.SkipWithError("it does not load");
  net::Cycle cycle;
  for (auto _ : state) {
    (*net)->evaluate(cycle);
    ++cycle.index;
  }
}

#define TAKT_CHAIN(function) \
  BENCHMARK(function)->Arg(16)->Arg(60)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond)
TAKT_CHAIN(MappingOfSets);
TAKT_CHAIN(LoadOfSets);
TAKT_CHAIN(PlanningOfMotions);
TAKT_CHAIN(MappingOfMotions);
TAKT_CHAIN(LoadOfMotions);
BENCHMARK(CycleOfSets)->Arg(16)->Arg(60)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace takt::command

BENCHMARK_MAIN();
