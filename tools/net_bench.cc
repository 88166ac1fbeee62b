#include "tools/net_bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::tools {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr int kBatch = 100;           ///< cycles between two looks at the clock
constexpr std::size_t kStride = 16;   ///< one primitive in so many is timed in a cycle
constexpr std::size_t kMost = 20000;  ///< samples kept of one thing

double nanoseconds_since(Clock::time_point begin) {
  return static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - begin).count());
}

/// Median of what two looks at the clock with nothing between them show.
double clock_cost() {
  std::vector<double> samples(5001);
  for (double& sample : samples) {
    const auto begin = Clock::now();
    sample = nanoseconds_since(begin);
  }
  std::ranges::nth_element(samples, samples.begin() + 2500);
  return samples[2500];
}

std::string processor_name() {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

Times times_of(std::vector<double>& samples, double clock_ns) {
  Times times;
  if (samples.empty()) return times;
  for (double& sample : samples) sample = std::max(0.0, sample - clock_ns);
  std::ranges::sort(samples);
  const auto at = [&](double share) {
    return samples[static_cast<std::size_t>(share * static_cast<double>(samples.size() - 1))];
  };
  // A machine that does other things now and then interrupts for milliseconds: that is not the primitive's cost.
  const auto quiet = static_cast<std::ptrdiff_t>(std::ceil(0.99 * static_cast<double>(samples.size())));
  times.mean = std::accumulate(samples.begin(), samples.begin() + quiet, 0.0) / static_cast<double>(quiet);
  times.p50 = at(0.5);
  times.p99 = at(0.99);
  times.largest = samples.back();
  return times;
}

/// Cycles of a net that nobody controls, until the time is over or the net failed.
class Runner {
 public:
  Runner(net::CompiledNet& net, double seconds) : net_(net), seconds_(seconds) {}

  [[nodiscard]] bool failed() const { return net_.signals().fail; }
  [[nodiscard]] std::int64_t cycles() const { return cycle_.index; }

  net::Cycle& next() {
    cycle_.time = cycle_.index * cycle_.period;
    ++cycle_.index;
    return cycle_;
  }

  /// Calls `step` until a share of the time is over.
  template <class Step>
  void for_share(double share, const Step& step) {
    const auto begin = Clock::now();
    while (!failed() && nanoseconds_since(begin) < share * seconds_ * 1e9) step();
  }

 private:
  net::CompiledNet& net_;
  double seconds_;
  net::Cycle cycle_;
};

/// The median of the means of batches.
double measure_batches(net::CompiledNet& net, Runner& runner) {
  std::vector<double> means;
  runner.for_share(0.3, [&] {
    const auto begin = Clock::now();
    for (int i = 0; i < kBatch; ++i) net.evaluate(runner.next());
    means.push_back(nanoseconds_since(begin) / kBatch);
  });
  if (means.empty()) return 0.0;
  const auto middle = means.begin() + static_cast<std::ptrdiff_t>(means.size() / 2);
  std::ranges::nth_element(means, middle);
  return *middle;
}

std::vector<double> measure_cycles(net::CompiledNet& net, Runner& runner) {
  std::vector<double> samples;
  runner.for_share(0.2, [&] {
    const auto begin = Clock::now();
    net.evaluate(runner.next());
    samples.push_back(nanoseconds_since(begin));
  });
  return samples;
}

std::vector<std::vector<double>> measure_parts(net::CompiledNet& net, Runner& runner) {
  const auto count = static_cast<std::size_t>(net.primitive_count());
  std::vector<std::vector<double>> samples(count);
  std::vector<std::int64_t> now(count);
  std::size_t first = 0;
  runner.for_share(0.5, [&] {
    net.evaluate_timed(runner.next(), first, kStride, now);
    for (std::size_t i = first; i < count; i += kStride) {
      // Nothing was measured where a fragment rests.
      if (now[i] > 0 && samples[i].size() < kMost) samples[i].push_back(static_cast<double>(now[i]));
      now[i] = 0;
    }
    first = (first + 1) % std::min(kStride, std::max<std::size_t>(count, 1));
  });
  return samples;
}

}  // namespace

Result<NetBench> bench_net(net::CompiledNet& net, double seconds) {
  Runner runner(net, seconds);
  for (int i = 0; i < kBatch && !runner.failed(); ++i) net.evaluate(runner.next());  // warm
  if (runner.failed()) {
    return failure(
        Code::kInternal, "",
        fmt::format("the net fails in cycle {}: {}", net.signals().cause.cycle, net.signals().cause.text.view()),
        "Give the devices samples: --scenario FILE");
  }
  NetBench bench;
  bench.processor = processor_name();
  bench.clock_ns = clock_cost();
  bench.cycle_ns = measure_batches(net, runner);
  auto cycles = measure_cycles(net, runner);
  bench.cycle = times_of(cycles, bench.clock_ns);
  auto parts = measure_parts(net, runner);
  double sum = 0.0;
  for (const net::NetReport::Primitive& primitive : net.report().primitives) {
    auto& samples = parts.at(static_cast<std::size_t>(primitive.order));
    bench.parts.push_back({primitive.id, primitive.info->type, times_of(samples, bench.clock_ns), 0.0});
    sum += bench.parts.back().ns.mean;
  }
  for (auto& part : bench.parts) part.share = sum > 0 ? part.ns.mean / sum : 0.0;
  std::ranges::stable_sort(bench.parts, std::ranges::greater(), [](const auto& part) { return part.ns.mean; });
  bench.cycles = runner.cycles();
  if (runner.failed()) bench.ended = std::string(net.signals().cause.text.view());
  return bench;
}

std::string to_text(const NetBench& bench, std::size_t most_lines) {
  std::string text = fmt::format(
      "{} cycles on {}\n"
      "a cycle   {:.1f} ns in batches of {}: {:.0f} cycles a second\n"
      "          single cycles: p50 {:.0f}, p99 {:.0f}, largest {:.0f} ns, less {:.0f} ns for the clock\n",
      bench.cycles, bench.processor, bench.cycle_ns, kBatch, bench.cycle_ns > 0 ? 1e9 / bench.cycle_ns : 0.0,
      bench.cycle.p50, bench.cycle.p99, bench.cycle.largest, bench.clock_ns);
  if (!bench.ended.empty()) text += fmt::format("the net failed on the way: {}\n", bench.ended);
  text += fmt::format("{:<36} {:<24} {:>8} {:>8} {:>8} {:>7}\n", "primitive", "type", "mean ns", "p50", "p99", "share");
  for (std::size_t i = 0; i < std::min(most_lines, bench.parts.size()); ++i) {
    const auto& part = bench.parts[i];
    text += fmt::format("{:<36} {:<24} {:>8.1f} {:>8.0f} {:>8.0f} {:>6.1f}%\n", part.id, part.type, part.ns.mean,
                        part.ns.p50, part.ns.p99, 100 * part.share);
  }
  if (bench.parts.size() > most_lines) text += fmt::format("and {} cheaper ones\n", bench.parts.size() - most_lines);
  return text;
}

Json to_json(const NetBench& bench) {
  const auto times = [](const Times& t) {
    return Json{{"mean", t.mean}, {"p50", t.p50}, {"p99", t.p99}, {"largest", t.largest}};
  };
  Json parts = Json::array();
  for (const auto& part : bench.parts) {
    parts.push_back({{"id", part.id}, {"type", part.type}, {"ns", times(part.ns)}, {"share", part.share}});
  }
  return {{"processor", bench.processor},  {"cycles", bench.cycles},      {"clock_ns", bench.clock_ns},
          {"cycle_ns", bench.cycle_ns},    {"cycle", times(bench.cycle)}, {"ended", bench.ended},
          {"primitives", std::move(parts)}};
}

}  // namespace takt::tools
