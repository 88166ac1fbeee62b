#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "tools/robustness/variations.h"

namespace takt::tools {

/// Least, middle and greatest of some numbers; all 0 of none.
struct Spread {
  double least = 0.0, median = 0.0, greatest = 0.0;
};
[[nodiscard]] Spread spread_of(std::vector<double> values);

/// What came of one expectation in all variations that judged it.
struct ExpectationSpread {
  struct JudgedRun {
    std::uint64_t seed = 0;
    bool passed = false;
    std::optional<double> value;  ///< nothing: not a number
  };
  std::string name, kind, unit = {};
  std::optional<double> lower = {}, upper = {};  ///< bounds, in `unit`
  std::vector<JudgedRun> judged = {};            ///< by seed

  [[nodiscard]] std::size_t passed() const;
  [[nodiscard]] Spread spread() const;
  /// Its values say more than that it passed.
  [[nodiscard]] bool measures() const { return !unit.empty() || lower || upper; }
};

/// All variations of a scenario, and how many of them have to pass.
struct Robustness {
  std::string file;
  std::string title;  ///< of the scenario, for people
  std::size_t needed = 0;
  std::vector<Variation> variations = {};
  double wall_s = 0.0;  ///< for all of them
  int jobs = 1;         ///< that ran at a time

  [[nodiscard]] std::size_t passed() const;
  [[nodiscard]] std::size_t interrupted() const;
  [[nodiscard]] bool all_ended_in_order() const;
  /// Enough have passed, and whatever did not ended with a report.
  [[nodiscard]] bool holds() const { return passed() >= needed && all_ended_in_order(); }
  /// Share of all possible variations that pass, at least, with 95 % confidence: the lower bound of Clopper and
  /// Pearson (Biometrika 26, 1934), one-sided.
  [[nodiscard]] double share_at_least() const;
  /// Least and greatest share, two-sided with 95 % confidence: the interval of Wilson, as of sweeps.
  [[nodiscard]] std::pair<double, double> interval() const;
  [[nodiscard]] std::vector<ExpectationSpread> expectations() const;
};

/// "1.25 mm": a value in the unit that its size asks for. `unit` as of an expectation.
[[nodiscard]] std::string amount_text(double value, const std::string& unit);
/// What the bounds say: "below 30 N", "29 N to 45 N"; empty without bounds.
[[nodiscard]] std::string bounds_text(const ExpectationSpread& expectation);

[[nodiscard]] nlohmann::ordered_json to_json(const Robustness& robustness);
/// For a terminal.
[[nodiscard]] std::string to_text(const Robustness& robustness);
/// For people: one page, with the films of failures inside, nothing loaded from elsewhere.
[[nodiscard]] std::string to_html(const Robustness& robustness);

}  // namespace takt::tools
