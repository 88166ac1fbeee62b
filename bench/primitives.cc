// Cost of each primitive type of the library in a cycle: 32 copies of its example in one net, per copy. Inputs are
// constants, so a generator stands at its target there; the rows of motion that is planned anew in every cycle come
// first.
#include <benchmark/benchmark.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/compiled_net.h"
#include "core/net/example.h"
#include "core/net/registry.h"
#include "tests/core/primitives/environment.h"

namespace takt {
namespace {

constexpr int kCopies = 32;

test::DeviceEnvironment& devices() {
  static test::DeviceEnvironment all;
  return all;
}

/// Runs the net; a row is the time of a cycle over `count`.
void run(benchmark::State& state, const net::NetDescription& description, int count) {
  const auto net = net::CompiledNet::compile(description, devices());
  if (!net) {
    state.SkipWithError(net.error().to_string().c_str());
    return;
  }
  net::Cycle cycle;
  for (auto _ : state) {
    (*net)->evaluate(cycle);
    ++cycle.index;
    cycle.time += cycle.period;
  }
  state.counters["each"] = benchmark::Counter(static_cast<double>(state.iterations() * count),
                                              benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void one_type(benchmark::State& state, const net::PrimitiveInfo& info) {
  const net::NetDescription example = net::example_net(info);
  net::NetDescription many;
  if (!info.termination) many.add("end", "Termination", {{"condition", false}});
  // A device may be driven once.
  const int copies = info.claims.empty() ? kCopies : 1;
  for (int i = 0; i < copies; ++i) many.add(fmt::format("p{}", i), info.type, example.primitives.front().parameters);
  run(state, many, copies);
}

/// A target that jumps in every cycle, so that every cycle plans a motion.
void online_generator(benchmark::State& state, int joints) {
  const auto all = [joints](double value) { return std::vector<double>(static_cast<std::size_t>(joints), value); };
  net::NetDescription net;
  net.add("end", "Termination", {{"condition", false}});
  net.add("noise", "UniformNoise", {{"seed", 1}, {"low", 0.0}, {"high", 1.0}});
  if (joints == 1) {
    net.add("motion", "JerkLimitedPosition", {{"velocity_max", 1.0}, {"acceleration_max", 5.0}, {"jerk_max", 50.0}});
    net.link("noise.value", "motion.target");
  } else {
    net.add("target", "InterpolateJoints", {{"a", all(-1.0)}, {"b", all(1.0)}}).link("noise.value", "target.share");
    net.add("motion", "JerkLimitedJointPosition",
            {{"joints", joints}, {"velocity_max", all(1.0)}, {"acceleration_max", all(5.0)}, {"jerk_max", all(50.0)}});
    net.link("target.value", "motion.target");
  }
  run(state, net, 1);
}

}  // namespace
}  // namespace takt

int main(int argc, char** argv) {
  for (const int joints : {1, 6, 7})
    benchmark::RegisterBenchmark(fmt::format("Ruckig, {} axes, new target each cycle", joints).c_str(),
                                 [joints](benchmark::State& state) { takt::online_generator(state, joints); });
  for (const auto* info : takt::net::Registry::global().all())
    benchmark::RegisterBenchmark(fmt::format("{}/{}", info->family, info->type).c_str(), [info](
                                                                                             benchmark::State& state) {
      takt::one_type(state, *info);
    })->MinTime(0.02);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
