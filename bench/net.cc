// Cost of nets: per cycle by size, a chain against the same chain written by hand, LOAD from memory and from JSON.
// Run with --benchmark_repetitions=20 --benchmark_report_aggregates_only for percentile-like spread.
#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/random.h"
#include "core/net/compiled_net.h"

namespace takt::net {
namespace {

class Nothing : public Environment {
 public:
  Resource* find(std::string_view) override { return nullptr; }
  [[nodiscard]] std::vector<std::string> names() const override { return {}; }
};

std::unique_ptr<CompiledNet> load(const NetDescription& description) {
  Nothing nothing;
  auto net = CompiledNet::compile(description, nothing);
  if (net) return std::move(*net);
  std::fputs(net.error().to_string().c_str(), stderr);
  std::abort();
}

std::string name(std::int64_t i) { return fmt::format("p{:06}", i); }

NetDescription chain(std::int64_t count) {
  NetDescription net;
  net.add("end", "Termination", {{"condition", false}}).add(name(0), "Add", {{"a", 0.5}, {"b", 1e-9}});
  for (std::int64_t i = 1; i < count; ++i) {
    net.add(name(i), "Add", {{"b", 1e-9}}).link(name(i - 1) + ".value", name(i) + ".a");
  }
  return net;
}

/// Scalar and logic primitives in equal parts, each reading earlier ones at random; ids in random order.
NetDescription mixed(std::int64_t count) {
  Random random(7);
  NetDescription net;
  net.add("end", "Termination", {{"condition", false}}).add("seed", "Gain", {{"input", 0.7}, {"factor", 1.0}});
  std::vector<std::string> reals{"seed.value"}, booleans;
  const auto any = [&](const std::vector<std::string>& ports) { return ports[random.bits() % ports.size()]; };
  for (std::int64_t i = 1; i < count; ++i) {
    const std::string id = fmt::format("p{:04x}-{}", random.bits() & 0xFFFFu, i);
    switch (random.bits() % 4) {
      case 0:
        net.add(id, "Add").link(any(reals), id + ".a").link(any(reals), id + ".b");
        reals.push_back(id + ".value");
        break;
      case 1:
        net.add(id, "Gain", {{"factor", 0.99}}).link(any(reals), id + ".input");
        reals.push_back(id + ".value");
        break;
      case 2:
        net.add(id, "GreaterThan").link(any(reals), id + ".a").link(any(reals), id + ".b");
        booleans.push_back(id + ".value");
        break;
      default:
        if (booleans.empty()) {
          net.add(id, "Gain", {{"factor", 1.0}}).link(any(reals), id + ".input");
        } else {
          net.add(id, "SelectReal").link(any(booleans), id + ".condition").link(any(reals), id + ".if_true");
          net.link(any(reals), id + ".if_false");
        }
        reals.push_back(id + ".value");
    }
  }
  return net;
}

void run(benchmark::State& state, const NetDescription& description) {
  const auto net = load(description);
  Cycle cycle;
  for (auto _ : state) {
    net->evaluate(cycle);
    ++cycle.index;
  }
  state.SetItemsProcessed(state.iterations() * net->primitive_count());
}

void Mixed(benchmark::State& state) { run(state, mixed(state.range(0))); }
BENCHMARK(Mixed)->Arg(50)->Arg(1000)->Arg(10000);

void ChainInNet(benchmark::State& state) { run(state, chain(500)); }
BENCHMARK(ChainInNet);

/// The same chain as a person writes it: objects that read through pointers, called in order.
struct HandAdd {
  virtual ~HandAdd() = default;
  virtual void run() { out = *a + *b; }
  const double *a = nullptr, *b = nullptr;
  double out = 0.0;
};

void ChainByHand(benchmark::State& state) {
  double first = 0.5, step = 1e-9;
  std::vector<HandAdd> adders(500);
  std::vector<HandAdd*> order;
  for (std::size_t i = 0; i < adders.size(); ++i) {
    adders[i].a = i == 0 ? &first : &adders[i - 1].out;
    adders[i].b = &step;
    order.push_back(&adders[i]);
  }
  benchmark::DoNotOptimize(order.data());
  for (auto _ : state) {
    for (HandAdd* adder : order) adder->run();
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * 500);
}
BENCHMARK(ChainByHand);

void LoadFromMemory(benchmark::State& state) {
  const NetDescription description = mixed(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(load(description));
}
BENCHMARK(LoadFromMemory)->Arg(50)->Arg(10000)->Unit(benchmark::kMillisecond);

void LoadChain(benchmark::State& state) {
  const NetDescription description = chain(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(load(description));
}
BENCHMARK(LoadChain)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond);

/// One source that all others read.
NetDescription star(std::int64_t count) {
  NetDescription net;
  net.add("end", "Termination", {{"condition", false}}).add("hub", "Gain", {{"input", 0.7}, {"factor", 1.0}});
  for (std::int64_t i = 0; i < count; ++i) {
    net.add(name(i), "Add", {{"b", 1e-9}}).link("hub.value", name(i) + ".a");
  }
  return net;
}

/// A chain with a tooth at each link.
NetDescription comb(std::int64_t count) {
  NetDescription net;
  net.add("end", "Termination", {{"condition", false}}).add(name(0), "Gain", {{"input", 0.7}, {"factor", 1.0}});
  for (std::int64_t i = 2; i < count; i += 2) {
    net.add(name(i), "Add").add(name(i + 1), "Gain", {{"input", 0.1}, {"factor", 1.0}});
    net.link(name(i - 2) + ".value", name(i) + ".a").link(name(i + 1) + ".value", name(i) + ".b");
  }
  return net;
}

/// Fragments inside one another: rejected, since 32 levels are the most.
NetDescription nested(std::int64_t depth) {
  NetDescription net;
  net.add("end", "Termination", {{"condition", false}});
  for (std::int64_t i = 0; i < depth; ++i) {
    FragmentDescription fragment;
    fragment.id = "f";
    fragment.net = std::move(net);
    net = NetDescription();
    net.fragments.push_back(std::move(fragment));
  }
  return net;
}

/// Pairs of fragments that take turns, each pair at a Merge: five primitives and a proof for each.
NetDescription turns(std::int64_t count) {
  NetDescription net;
  net.add("end", "Termination", {{"condition", false}}).add("x", "GreaterThan", {{"a", 1.0}, {"b", 0.0}});
  net.add("n", "Not").link("x.value", "n.input");
  for (std::int64_t i = 0; i < count / 5; ++i) {
    net.add(name(i), "MergeReal");
    for (const bool first : {true, false}) {
      FragmentDescription fragment;
      fragment.id = name(i) + (first ? "a" : "b");
      fragment.net.add("gain", "Gain", {{"input", 1.0}, {"factor", 2.0}}).add("sum", "Add", {{"b", 1.0}});
      fragment.net.link("gain.value", "sum.a");
      fragment.outputs.emplace_back("out", "sum.value");
      net.link(first ? "x.value" : "n.value", fragment.id + ".active");
      net.link(fragment.id + ".out", name(i) + (first ? ".input_1" : ".input_2"));
      net.fragments.push_back(std::move(fragment));
    }
  }
  return net;
}

template <NetDescription (*make)(std::int64_t)>
void LoadShape(benchmark::State& state) {
  const NetDescription description = make(state.range(0));
  Nothing nothing;
  for (auto _ : state) benchmark::DoNotOptimize(CompiledNet::compile(description, nothing));
}
BENCHMARK(LoadShape<star>)->Arg(100000)->Unit(benchmark::kMillisecond);
BENCHMARK(LoadShape<comb>)->Arg(100000)->Unit(benchmark::kMillisecond);
BENCHMARK(LoadShape<nested>)->Arg(100000)->Unit(benchmark::kMillisecond);
BENCHMARK(LoadShape<turns>)->Arg(100000)->Unit(benchmark::kMillisecond);

void LoadFromJson(benchmark::State& state) {
  const std::string text = net_to_json(mixed(state.range(0))).dump();
  for (auto _ : state) {
    auto document = parse_json(text);
    auto description = net_from_json(*document);
    benchmark::DoNotOptimize(load(*description));
  }
}
BENCHMARK(LoadFromJson)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace takt::net

BENCHMARK_MAIN();
