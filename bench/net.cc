// Cost of nets: per cycle by size, a chain against the same chain written by hand, LOAD from memory and from JSON.
// Run with --benchmark_repetitions=20 --benchmark_report_aggregates_only for percentile-like spread.
#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/random.h"
#include "core/net/compiled_net.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::net {
namespace {

class BenchAdd : public Primitive {
 public:
  explicit BenchAdd(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "u"})),
        out_(setup.out<Real>("out", {.unit = "u"})) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(*a_ + *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(BenchAdd, "bench", "Sum.");

class BenchGain : public Primitive {
 public:
  explicit BenchGain(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u"})),
        out_(setup.out<Real>("out", {.unit = "u"})),
        gain_(setup.parameter<Real>("gain", 1.0)) {}
  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    out_.set(*in_ * gain_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
  double gain_;
};
TAKT_PRIMITIVE(BenchGain, "bench", "Product with a parameter.");

class BenchGreater : public Primitive {
 public:
  explicit BenchGreater(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "u"})),
        out_(setup.out<Boolean>("out")) {}
  void update(const Cycle&) override {
    if (a_.null() || b_.null()) return out_.set_null();
    out_.set(*a_ > *b_);
  }

 private:
  In<Real> a_, b_;
  Out<Boolean> out_;
};
TAKT_PRIMITIVE(BenchGreater, "bench", "a > b.");

class BenchSelect : public Primitive {
 public:
  explicit BenchSelect(Setup& setup)
      : which_(setup.in<Boolean>("which")),
        a_(setup.in<Real>("a", {.unit = "u"})),
        b_(setup.in<Real>("b", {.unit = "u"})),
        out_(setup.out<Real>("out", {.unit = "u"})) {}
  void update(const Cycle&) override {
    const In<Real>& taken = !which_.null() && *which_ ? a_ : b_;
    if (which_.null() || taken.null()) return out_.set_null();
    out_.set(*taken);
  }

 private:
  In<Boolean> which_;
  In<Real> a_, b_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(BenchSelect, "bench", "which ? a : b.");

class BenchEnd : public Primitive {
 public:
  explicit BenchEnd(Setup& setup) { setup.is_termination(); }
  void update(const Cycle&) override {}
};
TAKT_PRIMITIVE(BenchEnd, "bench", "Never ends.");

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
  net.add("end", "BenchEnd").add(name(0), "BenchAdd", {{"a", 0.5}, {"b", 1e-9}});
  for (std::int64_t i = 1; i < count; ++i) {
    net.add(name(i), "BenchAdd", {{"b", 1e-9}}).link(name(i - 1) + ".out", name(i) + ".a");
  }
  return net;
}

/// Scalar and logic primitives in equal parts, each reading earlier ones at random; ids in random order.
NetDescription mixed(std::int64_t count) {
  Random random(7);
  NetDescription net;
  net.add("end", "BenchEnd").add("seed", "BenchGain", {{"in", 0.7}});
  std::vector<std::string> reals{"seed.out"}, booleans;
  const auto any = [&](const std::vector<std::string>& ports) { return ports[random.bits() % ports.size()]; };
  for (std::int64_t i = 1; i < count; ++i) {
    const std::string id = fmt::format("p{:04x}-{}", random.bits() & 0xFFFFu, i);
    switch (random.bits() % 4) {
      case 0:
        net.add(id, "BenchAdd").link(any(reals), id + ".a").link(any(reals), id + ".b");
        reals.push_back(id + ".out");
        break;
      case 1:
        net.add(id, "BenchGain", {{"gain", 0.99}}).link(any(reals), id + ".in");
        reals.push_back(id + ".out");
        break;
      case 2:
        net.add(id, "BenchGreater").link(any(reals), id + ".a").link(any(reals), id + ".b");
        booleans.push_back(id + ".out");
        break;
      default:
        if (booleans.empty()) {
          net.add(id, "BenchGain").link(any(reals), id + ".in");
        } else {
          net.add(id, "BenchSelect").link(any(booleans), id + ".which").link(any(reals), id + ".a");
          net.link(any(reals), id + ".b");
        }
        reals.push_back(id + ".out");
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
