#include "tools/robustness/robustness.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Probability of at least `k` successes in `n` independent trials of probability `p` each.
double at_least_successes(std::size_t k, std::size_t n, double p) {
  double sum = 0.0;
  for (std::size_t i = k; i <= n; ++i) {
    const auto successes = static_cast<double>(i), trials = static_cast<double>(n);
    sum += std::exp(std::lgamma(trials + 1) - std::lgamma(successes + 1) - std::lgamma(trials - successes + 1) +
                    successes * std::log(p) + (trials - successes) * std::log1p(-p));
  }
  return sum;
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

/// A run's report has more than what counts here: it is passed on as it is.
Json to_json(const Variation& variation) {
  const Json report = variation.report ? Json::parse(variation.end.output) : Json::object();
  return {{"seed", variation.seed},
          {"status", variation.end.status},
          {"signal", variation.end.signal != 0 ? Json(variation.end.signal) : Json()},
          {"result", report.value("result", Json())},
          {"message", variation.message()},
          {"sim_time", report.value("sim_time", Json())},
          {"wall_time", variation.end.wall_s},
          {"digest", report.value("digest", Json())},
          {"filmed", !variation.film.empty()},
          {"expectations", report.value("expectations", Json::array())},
          {"diagnostics", report.value("diagnostics", Json::array())}};
}

Json to_json(const ExpectationSpread& expectation) {
  const Spread spread = expectation.spread();
  return {{"name", expectation.name},
          {"kind", expectation.kind},
          {"judged", expectation.judged.size()},
          {"passed", expectation.passed()},
          {"unit", expectation.unit},
          {"lower", or_null(expectation.lower)},
          {"upper", or_null(expectation.upper)},
          {"least", spread.least},
          {"median", spread.median},
          {"greatest", spread.greatest}};
}

ExpectationSpread& entry_for(std::vector<ExpectationSpread>& all, const JudgedExpectation& judged) {
  const auto found = std::ranges::find(all, judged.name, &ExpectationSpread::name);
  if (found != all.end()) return *found;
  return all.emplace_back(ExpectationSpread{.name = judged.name, .kind = judged.kind});
}

std::string cut_off_text(std::size_t count) { return count > 0 ? fmt::format(", {} cut off", count) : ""; }

}  // namespace

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  return {values.front(), median, values.back()};
}

std::size_t ExpectationSpread::passed() const {
  return static_cast<std::size_t>(std::ranges::count(judged, true, &JudgedRun::passed));
}

Spread ExpectationSpread::spread() const {
  std::vector<double> values;
  for (const JudgedRun& one : judged)
    if (one.value) values.push_back(*one.value);
  return spread_of(std::move(values));
}

std::size_t Robustness::passed() const {
  return static_cast<std::size_t>(std::ranges::count_if(variations, &Variation::passed));
}

std::size_t Robustness::interrupted() const {
  return static_cast<std::size_t>(std::ranges::count_if(variations, &Variation::interrupted));
}

bool Robustness::all_ended_in_order() const { return std::ranges::all_of(variations, &Variation::ended_in_order); }

double Robustness::share_at_least() const {
  constexpr double kRisk = 0.05;
  constexpr int kHalvings = 40;
  double low = 0.0, high = 1.0;
  if (passed() == 0) return 0.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (at_least_successes(passed(), variations.size() - interrupted(), middle) < kRisk ? low : high) = middle;
  }
  return low;
}

std::pair<double, double> Robustness::interval() const {
  constexpr double kZ = 1.959963984540054;
  const auto n = static_cast<double>(variations.size() - interrupted()), k = static_cast<double>(passed());
  if (n == 0.0) return {0.0, 1.0};
  const double p = k / n, middle = p + kZ * kZ / (2.0 * n);
  const double width = kZ * std::sqrt(p * (1.0 - p) / n + kZ * kZ / (4.0 * n * n));
  const double below = 1.0 + kZ * kZ / n;
  return {k == 0.0 ? 0.0 : (middle - width) / below, k == n ? 1.0 : (middle + width) / below};
}

std::vector<ExpectationSpread> Robustness::expectations() const {
  std::vector<ExpectationSpread> all;
  for (const Variation& variation : variations) {
    if (!variation.report || variation.interrupted()) continue;
    for (const JudgedExpectation& judged : variation.report->expectations) {
      if (!judged.judged) continue;
      ExpectationSpread& entry = entry_for(all, judged);
      entry.judged.push_back({.seed = variation.seed, .passed = judged.passed, .value = judged.value});
      // What never came to be measured has neither.
      if (!judged.unit.empty()) entry.unit = judged.unit;
      if (judged.lower) entry.lower = judged.lower;
      if (judged.upper) entry.upper = judged.upper;
    }
  }
  return all;
}

std::string amount_text(double value, const std::string& unit) {
  if (unit == "m" && std::abs(value) < 0.1) return fmt::format("{:.3g} mm", 1e3 * value);
  return unit.empty() ? fmt::format("{:.3g}", value) : fmt::format("{:.3g} {}", value, unit);
}

std::string bounds_text(const ExpectationSpread& expectation) {
  const auto &lower = expectation.lower, &upper = expectation.upper;
  if (lower && upper)
    return fmt::format("{} to {}", amount_text(*lower, expectation.unit), amount_text(*upper, expectation.unit));
  if (lower) return "at least " + amount_text(*lower, expectation.unit);
  return upper ? "at most " + amount_text(*upper, expectation.unit) : "";
}

Json to_json(const Robustness& robustness) {
  Json variations = Json::array(), expectations = Json::array();
  for (const Variation& one : robustness.variations) variations.push_back(to_json(one));
  for (const ExpectationSpread& one : robustness.expectations()) expectations.push_back(to_json(one));
  return {{"result", robustness.interrupted() > 0 ? "interrupted"
                     : robustness.holds()         ? "passed"
                                                  : "failed"},
          {"file", robustness.file},
          {"seeds", robustness.variations.size()},
          {"passed", robustness.passed()},
          {"interrupted", robustness.interrupted()},
          {"needed", robustness.needed},
          {"share_at_least", robustness.share_at_least()},
          {"interval_95", {robustness.interval().first, robustness.interval().second}},
          {"wall_time", robustness.wall_s},
          {"jobs", robustness.jobs},
          {"expectations", std::move(expectations)},
          {"variations", std::move(variations)}};
}

std::string to_text(const Robustness& robustness) {
  std::string text = fmt::format("{}: {} of {} seeds passed ({} needed){} in {:.1f} s\n", robustness.file,
                                 robustness.passed(), robustness.variations.size(), robustness.needed,
                                 cut_off_text(robustness.interrupted()), robustness.wall_s);
  for (const ExpectationSpread& one : robustness.expectations()) {
    const Spread spread = one.spread();
    text += fmt::format("  {:>3}/{:<3} {}", one.passed(), one.judged.size(), one.name);
    if (one.measures()) {
      text += fmt::format(": {} ... {} ... {}", amount_text(spread.least, one.unit),
                          amount_text(spread.median, one.unit), amount_text(spread.greatest, one.unit));
      if (!bounds_text(one).empty()) text += " (" + bounds_text(one) + ")";
    }
    text += "\n";
  }
  for (const Variation& one : robustness.variations)
    if (!one.passed()) text += fmt::format("  seed {}: {}\n", one.seed, one.message());
  return text;
}

}  // namespace takt::tools
