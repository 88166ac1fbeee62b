#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "record/comparison.h"

namespace takt::record {

/// Equal times at which the columns of a topic have their samples.
struct GoldenGrid {
  Nanoseconds start = 0, period = 0;
  std::size_t samples = 0;
  friend bool operator==(const GoldenGrid&, const GoldenGrid&) = default;
};

/// A column on its topic's grid. It is what its pieces give at each sample, on top of the column that it follows.
struct GoldenCurve {
  int exponent = 0;                       ///< of the step of `pieces`, a power of ten
  std::optional<int> rate_exponent = {};  ///< the pieces are rates, and the column their integral
  std::string pieces = {};                ///< as to_text(PieceCurve) writes them; empty: zero throughout
  /// A signal that is sampled every so many samples, from sample `hold_from` on, and held in between.
  std::size_t hold_every = 1, hold_from = 0;
  std::string follows_topic = {}, follows_column = {};  ///< an earlier column of the golden; empty: none
  std::size_t delay = 0;                                ///< samples by which it follows
  bool rate = false;                                    ///< it is the rate of that column, which is one of rates
};

/// One column of a golden, which stays within `thinning` of every sample of the run: a curve on the topic's grid, or,
/// where samples are not at equal times or judged to the bit, points with straight lines between them.
struct GoldenColumn {
  std::string topic, column, unit;
  Tolerance tolerance;
  double thinning = 0.0;  ///< in the column's unit, a quarter of the tolerance, or half of it if need be
  std::optional<GoldenCurve> curve = {};
  std::vector<double> time_s = {}, value = {};  ///< points; NaN = null from here to the next one
};

struct GoldenEvent {
  std::string topic, source, name;
  double time_s = 0.0;
  std::string step = {};  ///< path of the step in which it happened
};

/// A run that a person has looked at and approved, small enough for the repository. It is compared with tolerances, so
/// that it holds across machines and harmless changes of code; whether the digest is still the same is told, and judged
/// only on request (row D5).
struct Golden {
  std::string scenario;  ///< as the caller names it
  std::string reason;    ///< why this run is right, in words; never empty
  std::map<std::string, std::string> fingerprint;
  std::uint64_t cycles = 0;
  double end_s = 0.0;
  std::string digest;                       ///< of the last cycle, 16 hexadecimal digits; empty if the run has none
  std::map<std::string, GoldenGrid> grids;  ///< by topic
  std::vector<GoldenColumn> columns;        ///< what a column follows comes before it
  Tolerance event_tolerance;
  std::vector<GoldenEvent> events;
};

}  // namespace takt::record
