// takt doctor: what this machine can do for a cycle in real time, and what to change.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/base/processors.h"
#include "tools/cli.h"
#include "tools/machine.h"

namespace takt::tools {
namespace {

/// A tenth of a cycle of 1 ms: what is left is for the nets, and for devices that want an answer within the cycle.
constexpr Nanoseconds kWorstWakeup = 100'000;

double us(Nanoseconds time) { return 1e-3 * static_cast<double>(time); }

int doctor(double seconds, int processor, const Common& common) {
  if (processor >= 0 && !has_processor(processor)) {
    Diagnostics diagnostics;
    diagnostics.error(Code::kOutOfRange, "--processor", fmt::format("this process may not use processor {}", processor),
                      "Give the number of one that is online");
    return report(diagnostics, common);
  }
  const std::vector<MachineFinding> findings = look_at_machine();
  const MeasuredCycles measured = measure_cycles(seconds, processor);
  const rcc::LatenessTimes& late = measured.wakeups;
  const bool in_time = late.worst() <= kWorstWakeup;
  const bool fit = in_time && measured.realtime_scheduling && measured.locked_memory;
  if (common.json) {
    auto list = nlohmann::ordered_json::array();
    for (const MachineFinding& one : findings)
      list.push_back({{"name", one.name}, {"good", one.good}, {"found", one.found}, {"change", one.change}});
    print({{"result", fit ? "fit" : "not fit"},
           {"machine", std::move(list)},
           {"realtime_scheduling", measured.realtime_scheduling},
           {"locked_memory", measured.locked_memory},
           {"wakeups",
            {{"count", late.count()},
             {"p50_ns", late.quantile(0.5)},
             {"p99_ns", late.quantile(0.99)},
             {"p999_ns", late.quantile(0.999)},
             {"worst_ns", late.worst()}}}});
    return fit ? kHeld : kNotHeld;
  }
  for (const MachineFinding& one : findings) {
    fmt::print("  {} {:<12} {}\n", one.good ? "ok  " : "poor", one.name, one.found);
    if (!one.change.empty()) fmt::print("       {:<12} better: {}\n", "", one.change);
  }
  fmt::print(
      "  {} {:<12} {} of 1 ms: {:.0f} us late (median), {:.0f} us (99 %), {:.0f} us (99.9 %), {:.0f} us (worst)\n",
      in_time ? "ok  " : "poor", "wake-ups", late.count(), us(late.quantile(0.5)), us(late.quantile(0.99)),
      us(late.quantile(0.999)), us(late.worst()));
  fmt::print("{}\n", fit ? "This machine can drive devices at 1 kHz, as far as this short measurement shows."
                         : "This machine runs simulations; for real devices at 1 kHz it needs the changes above.");
  return fit ? kHeld : kNotHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_doctor(CLI::App& parser, Common& common) {
  auto seconds = std::make_shared<double>(2.0);
  auto processor = std::make_shared<int>(-1);
  CLI::App* verb =
      parser.add_subcommand("doctor", "What this machine can do for a cycle of 1 ms in real time, and what to change");
  verb->add_option("--seconds", *seconds, "How long wake-ups are measured")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  verb->add_option("--processor", *processor, "The only processor on which they are measured")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  return {verb, [seconds, processor, &common] { return doctor(*seconds, *processor, common); }};
}

}  // namespace takt::tools
