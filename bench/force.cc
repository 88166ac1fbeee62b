// How well a force is brought up and held: `press` on surfaces of three stiffnesses, `force_offset` along a flat one, a
// slope and a step, a touch that ends a guarded motion. True contact forces from the simulation, three arms. The tables
// are those of docs/benchmarks.md. Run from the root of the repository:
//   bench_force [press|slide|crown|touch|all] [lwr4plus|ur5|tx90] [--curves FOLDER]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cell/run/session.h"

namespace takt {
namespace {

constexpr double kPeriod = 1e-3;

struct Arm {
  const char* name;
  const char* probe;
  /// Of motions that slide, in the axes of the tool.
  const char* compliance = "";
};
constexpr const char* kSprings = R"(, "compliance": {"mode": "cartesian_impedance", "axes": "tool",
          "stiffness_N_m": [3000, 3000, 500], "rotational_stiffness_Nm_rad": [200, 200, 200]})";
constexpr Arm kArms[] = {
    {"lwr4plus", "probe_ball"}, {"ur5", "probe_ball"}, {"tx90", "probe_sprung"}, {"tx90", "probe_ball"}};
/// What gives way by itself slides over what comes too fast for any law.
constexpr Arm kOnSprings{"lwr4plus", "probe_ball", kSprings};

/// What a step did to the surface: the force along the direction that is controlled, N, in each cycle.
struct Trace {
  std::vector<double> force;
  std::string failure;
};

struct Surface {
  double stiffness = 1e5;  ///< N/m
  double slope_deg = 0.0;
  double step = 0.0;  ///< m, across the path, 40 mm from where it begins
  bool pipe = false;  ///< of 150 mm radius, across the path; its crown as high as the block
};

std::string objects(const Surface& surface) {
  const std::string pose =
      fmt::format(R"("at": {{"in": "world", "position_m": [0.56, 0, 0.8], "rpy_deg": [{}, 0, 0]}})", surface.slope_deg);
  std::string parts = R"({"shape": "box", "size_m": [0.1, 0.3, 0.05]})";
  if (surface.pipe)
    parts = R"({"shape": "cylinder", "radius_m": 0.15, "length_m": 0.3, "position_m": [0, 0, -0.125],
        "rpy_deg": [0, 90, 0]})";
  if (surface.step < 0.0) parts = R"({"shape": "box", "size_m": [0.1, 0.15, 0.05], "position_m": [0, -0.075, 0]})";
  if (surface.step != 0.0)
    parts +=
        fmt::format(R"(, {{"shape": "box", "size_m": [0.1, 0.1, 0.05], "position_m": [0, 0.05, {}]}})", surface.step);
  return fmt::format(R"("objects": {{"block": {{"parts": [{}], "stiffness_N_m": {}, "friction": 0.2, {}}}}})", parts,
                     surface.stiffness, pose);
}

/// An arm with a probe 5 mm above the surface, tared; then the steps.
std::string scenario_of(const Arm& arm, const Surface& surface, double y_m, const std::string& steps) {
  return fmt::format(R"({{"time_limit_s": 100, "devices": {{
        "arm": {{"model": "{}", "at": {{"in": "world", "position_m": [0, 0, 0.75]}}}},
        "wrist": {{"model": "ft_gamma", "on": "arm"}}, "probe": {{"model": "{}", "on": "wrist", "friction": 0.2}}}}, {},
      "program": {{"do": "sequence", "steps": [
        {{"do": "ptp", "to": {{"in": "block", "position_m": [0, {}, 0.035], "rpy_deg": [{}, 0, 0]}}}},
        {{"do": "wait", "seconds": 0.3}}, {{"do": "tare"}}, {}]}},
      "expectations": [{{"kind": "limits"}}]}})",
                     arm.name, arm.probe, objects(surface), y_m, 180.0 - surface.slope_deg, steps);
}

/// @param pushing_W  direction of the force that is controlled
Trace run(const std::string& text, const Eigen::Vector3d& pushing_W = -Eigen::Vector3d::UnitZ()) {
  static const device::ModelLibrary models({"models"});
  Trace trace;
  auto description = cell::parse_description(text);
  if (!description) {
    trace.failure = description.error().to_string();
    return trace;
  }
  auto session = cell::Session::create(std::move(*description), models);
  if (!session) {
    trace.failure = session.error().to_string();
    return trace;
  }
  std::optional<std::size_t> watch;
  cell::RunOptions options;
  options.measure_times = false;
  options.after_cycle = [&](cell::BuiltCell& built) {
    if (!watch) watch = built.world->watch_contact("probe", "block").value();
    trace.force.push_back(pushing_W.dot(built.world->contact(*watch).force_W));
    return true;
  };
  const cell::RunReport report = (*session)->run(options);
  trace.failure = report.diagnostics.to_string();
  return trace;
}

std::size_t first_contact(std::span<const double> force) {
  return static_cast<std::size_t>(std::ranges::find_if(force, [](double f) { return f > 0.0; }) - force.begin());
}

struct Spread {
  double mean = 0.0, deviation = 0.0;
};
Spread spread(std::span<const double> values) {
  if (values.empty()) return {};
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0.0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return {.mean = mean, .deviation = std::sqrt(squares / n)};
}

double largest(std::span<const double> values) { return values.empty() ? 0.0 : std::ranges::max(values); }

/// From the first contact until the force, as a mean over 20 ms, stays within a share of the wanted one, s.
double settled_after(std::span<const double> force, double wanted, double share) {
  constexpr std::size_t kMean = 20;
  std::size_t last_out = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    sum += force[i] - (i >= kMean ? force[i - kMean] : 0.0);
    const double mean = sum / static_cast<double>(std::min(i + 1, kMean));
    if (std::abs(mean - wanted) > share * wanted) last_out = i + 1;
  }
  return static_cast<double>(last_out) * kPeriod;
}

/// The arm, and its tip where that yields.
std::string label(const Arm& arm) {
  if (*arm.compliance != '\0') return fmt::format("{}, on springs", arm.name);
  return arm.probe == std::string("probe_ball") ? arm.name : fmt::format("{}, sprung", arm.name);
}

std::string curves;  // folder

void write_curve(const std::string& name, std::span<const double> force) {
  if (curves.empty()) return;
  std::ofstream file(curves + "/" + name + ".csv");
  file << "time_s,force_N\n";
  for (std::size_t i = 0; i < force.size(); ++i)
    file << fmt::format("{:.3f},{:.3f}\n", 1e-3 * static_cast<double>(i), force[i]);
}

void press(const Arm& arm, double stiffness, double wanted) {
  const std::string step = fmt::format(
      R"({{"do": "press", "direction": [0, 0, -1], "in": "world", "force_N": {}, "approach_m_s": 0.005, "travel_m": 0.1,
          "seconds": 4}})",
      wanted);
  const Trace trace = run(scenario_of(arm, {.stiffness = stiffness}, 0.0, step));
  const std::span<const double> all(trace.force);
  const std::span<const double> force = all.subspan(first_contact(all));
  const std::span<const double> end = force.subspan(force.size() > 1000 ? force.size() - 1000 : 0);
  const Spread rest = spread(end);
  const double blow = largest(force.first(std::min<std::size_t>(50, force.size())));
  const double later = force.size() > 50 ? largest(force.subspan(50)) : 0.0;
  std::printf("| %s | %.0e | %g | %.1f | %+.0f %% | %.2f | %.2f | %.2f | %s\n", label(arm).c_str(), stiffness, wanted,
              blow, 100.0 * (later / wanted - 1.0), settled_after(force, wanted, 0.05), rest.mean, rest.deviation,
              trace.failure.c_str());
  std::fflush(stdout);
  write_curve(fmt::format("press-{}-{:.0e}-{}", label(arm), stiffness, wanted), force);
}

void slide(const Arm& arm, const char* name, const Surface& surface, double wanted, double speed) {
  const double length = 0.08;
  const std::string steps = fmt::format(
      R"({}{{"do": "press", "direction": [0, 0, -1], "in": "world", "force_N": {}, "approach_m_s": 0.005,
          "travel_m": 0.1, "seconds": 0.5{}}},
         {{"do": "lin", "name": "slide", "to": {{"by_m": [0, {}, 0]}}, "velocity_m_s": {}, "acceleration": 0.5,
          "force_offset": {{"force_N": {}, "reach_m": 0.03}}{}}})",
      *arm.compliance != '\0' ? R"({"do": "control_mode", "mode": "cartesian_impedance"}, )" : "", wanted,
      arm.compliance, length, speed, wanted, arm.compliance);
  const Trace trace = run(scenario_of(arm, surface, -0.04, steps));
  const std::span<const double> all(trace.force);
  const auto cycles = static_cast<std::size_t>(length / speed / kPeriod);
  const std::span<const double> force = all.last(std::min(cycles, all.size()));
  const Spread held = spread(force);
  constexpr std::size_t kStart = 500;  // cycles: the surface begins to come or go
  const Spread later = spread(force.subspan(std::min(kStart, force.size())));
  const auto lost = std::ranges::count_if(force, [](double f) { return f <= 0.0; });
  std::printf("| %s | %s | %g | %g | %+.1f %% | %.1f %% | %+.1f %% | %.1f %% | %.1f | %ld | %s\n", label(arm).c_str(),
              name, wanted, 1e3 * speed, 100.0 * (held.mean / wanted - 1.0), 100.0 * held.deviation / wanted,
              100.0 * (later.mean / wanted - 1.0), 100.0 * later.deviation / wanted, largest(force),
              static_cast<long>(lost), trace.failure.c_str());
  std::fflush(stdout);
  write_curve(fmt::format("slide-{}-{}-{}-{}", label(arm), name, wanted, speed), force);
}

/// Over the crown of a pipe, 50 mm on both sides, after a press or as it meets the pipe on its way.
void crown(const Arm& arm, double stiffness, double wanted, double speed, bool pressed) {
  const double length = 0.1;
  const std::string press = fmt::format(
      R"({{"do": "press", "direction": [0, 0, -1], "in": "world", "force_N": {}, "approach_m_s": 0.005,
          "travel_m": 0.1, "seconds": 0.5}}, )",
      wanted);
  const std::string steps = fmt::format(
      R"({}{{"do": "lin", "name": "slide", "to": {{"by_m": [0, {}, 0]}}, "velocity_m_s": {}, "acceleration": 0.3,
          "force_offset": {{"force_N": {}, "reach_m": 0.03, "retreat_m": 0.03, "velocity_max_m_s": 0.04}}}})",
      pressed ? press : R"({"do": "lin", "to": {"by_m": [0, 0, -0.007]}, "velocity_m_s": 0.02}, {"do": "tare"}, )",
      length, speed, wanted);
  const Trace trace = run(scenario_of(arm, {.stiffness = stiffness, .pipe = true}, -0.05, steps));
  const std::span<const double> all(trace.force);
  const auto cycles = static_cast<std::size_t>(length / speed / kPeriod);
  const std::span<const double> slide =
      pressed ? all.last(std::min(cycles, all.size())) : all.subspan(first_contact(all));
  constexpr std::size_t kStart = 300;  // cycles: it learns
  const std::span<const double> later = slide.subspan(std::min(kStart, slide.size()));
  const Spread held = spread(slide), rest = spread(later);
  const auto lost = [](std::span<const double> force) {
    return static_cast<long>(std::ranges::count_if(force, [](double f) { return f <= 0.0; }));
  };
  std::printf("| %s | %.0e | %s | %g | %g | %+.1f %% | %.1f %% | %+.1f %% | %.1f %% | %.1f | %ld | %ld | %s\n",
              label(arm).c_str(), stiffness, pressed ? "pressed" : "on the way", wanted, 1e3 * speed,
              100.0 * (held.mean / wanted - 1.0), 100.0 * held.deviation / wanted, 100.0 * (rest.mean / wanted - 1.0),
              100.0 * rest.deviation / wanted, largest(slide), lost(slide), lost(later), trace.failure.c_str());
  std::fflush(stdout);
  write_curve(fmt::format("crown-{}-{:.0e}-{}-{}-{}", label(arm), stiffness, wanted, speed, pressed), slide);
}

void touch(const Arm& arm, double stiffness) {
  const std::string step =
      R"({"do": "lin", "to": {"by_m": [0, 0, -0.025]}, "velocity_m_s": 0.005,
          "until": {"sensor": "wrist", "quantity": "force", "above_N": 5}}, {"do": "wait", "seconds": 0.3})";
  const Trace trace = run(scenario_of(arm, {.stiffness = stiffness}, 0.0, step));
  std::printf("| %s | %.0e | %.1f | %.1f | %s\n", label(arm).c_str(), stiffness, largest(trace.force),
              trace.force.empty() ? 0.0 : trace.force.back(), trace.failure.c_str());
  std::fflush(stdout);
}

}  // namespace
}  // namespace takt

int main(int argc, char** argv) {
  using namespace takt;
  std::string what = "all", only;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--curves" && i + 1 < argc)
      curves = argv[++i];
    else if (word == "press" || word == "slide" || word == "crown" || word == "touch" || word == "all")
      what = word;
    else
      only = word;
  }
  const auto each_arm = [&](const auto& measure) {
    for (const Arm& arm : kArms)
      if (only.empty() || only == arm.name) measure(arm);
  };
  if (what == "all" || what == "press") {
    std::printf(
        "| arm | N/m | N | blow, N | over | settled, s | mean, N | sd, N |\n|---|---|---|---|---|---|---|---|\n");
    each_arm([](const Arm& arm) {
      for (const double stiffness : {1e4, 1e5, 1e6})
        for (const double wanted : {5.0, 20.0, 50.0}) press(arm, stiffness, wanted);
    });
  }
  if (what == "all" || what == "slide") {
    std::printf(
        "| arm | surface | N | mm/s | mean | sd | mean after 0.5 s | sd | most, N | lost "
        "|\n|---|---|---|---|---|---|---|---|---|---|\n");
    const auto all_slides = [](const Arm& arm) {
      for (const auto& [name, surface] : {std::pair<const char*, Surface>{"flat", {}},
                                          {"slope", {.slope_deg = 10.0}},
                                          {"step", {.step = 0.001}},
                                          {"step down", {.step = -0.001}}})
        for (const double wanted : {8.0, 20.0})
          for (const double speed : {0.005, 0.02, 0.05}) slide(arm, name, surface, wanted, speed);
    };
    each_arm(all_slides);
    if (only.empty() || only == kOnSprings.name) all_slides(kOnSprings);
  }
  if (what == "all" || what == "crown") {
    std::printf(
        "| arm | N/m | touched | N | mm/s | mean | sd | mean after 0.3 s | sd | most, N | lost | lost after 0.3 s "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    each_arm([](const Arm& arm) {
      for (const double stiffness : {1e5, 6e5})
        for (const bool pressed : {true, false})
          for (const double speed : {0.01, 0.02, 0.05}) crown(arm, stiffness, 10.0, speed, pressed);
    });
  }
  if (what == "all" || what == "touch") {
    std::printf("| arm | N/m | peak, N | at rest, N |\n|---|---|---|---|\n");
    each_arm([](const Arm& arm) {
      for (const double stiffness : {1e5, 1e6}) touch(arm, stiffness);
    });
  }
  return 0;
}
