#include "core/motion/time_law.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::motion {
LawPoint advanced(const LawPoint& from, double t) {
  return {.s = from.s + t * (from.ds + t / 2 * (from.dds + t / 3 * from.ddds)),
          .ds = from.ds + t * (from.dds + t / 2 * from.ddds),
          .dds = from.dds + t * from.ddds,
          .ddds = from.ddds};
}

TimeLaw::TimeLaw(std::vector<Segment> segments, const Begin& begin) : begin_(begin), segments_(std::move(segments)) {
  if (segments_.empty()) return;
  knots_.reserve(segments_.size() + 1);
  double tau = 0.0;
  LawPoint point{.s = 0.0, .ds = begin.ds, .dds = begin.dds, .ddds = 0.0};
  for (const Segment& segment : segments_) {
    point.ddds = segment.jerk;
    knots_.push_back({tau, point});
    point = advanced(point, segment.duration_s);
    tau += segment.duration_s;
  }
  point.ddds = 0.0;
  knots_.push_back({tau, point});
}

Result<TimeLaw> TimeLaw::create(std::vector<Segment> segments, const Begin& begin) {
  Diagnostics diagnostics;
  if (!(std::isfinite(begin.ds) && std::isfinite(begin.dds) && begin.ds >= 0.0))
    diagnostics.error(Code::kOutOfRange, "/begin", fmt::format("ds = {} 1/s, dds = {} 1/s^2", begin.ds, begin.dds),
                      "Give finite numbers that do not run backwards");
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto [duration, jerk] = segments[i];
    if (!std::isfinite(duration) || duration < 0.0) {
      diagnostics.error(Code::kOutOfRange, pointer_segment(i), fmt::format("duration {} s of a segment", duration),
                        "Give a finite number >= 0");
    }
    if (!std::isfinite(jerk))
      diagnostics.error(Code::kOutOfRange, pointer_segment(i), fmt::format("jerk {} of a segment", jerk),
                        "Give a finite number");
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  TimeLaw law(std::move(segments), begin);
  if (law.knots_.empty()) return law;
  constexpr double kEndTolerance = 1e-9;
  double fastest = 0.0;
  double strongest = 0.0;
  for (const Knot& knot : law.knots_) {
    fastest = std::max(fastest, std::abs(knot.point.ds));
    strongest = std::max(strongest, std::abs(knot.point.dds));
  }
  const LawPoint& end = law.knots_.back().point;
  if (!(std::abs(end.s - 1.0) <= kEndTolerance)) {
    diagnostics.error(Code::kOutOfRange, {}, fmt::format("the law ends at s = {}", end.s),
                      "Run the law from s = 0 to s = 1");
  }
  if (!(std::abs(end.ds) <= kEndTolerance * fastest) || !(std::abs(end.dds) <= kEndTolerance * strongest)) {
    diagnostics.error(Code::kOutOfRange, {},
                      fmt::format("the law ends with ds = {} 1/s and dds = {} 1/s^2", end.ds, end.dds),
                      "End the law at rest");
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return law;
}

TimeLaw TimeLaw::rest_to_rest(const RateLimits& limits) {
  const auto [v, a, j] = limits;
  // The jerk acts for tj in each of four pieces: as long as the way, the acceleration or the velocity limit lets it.
  const double tj = std::min({std::cbrt(1.0 / (2.0 * j)), a / j, std::sqrt(v / j)});
  const double peak = j * tj;  // acceleration
  // ta at that acceleration: the way without cruise is peak (tj + ta)(2 tj + ta) = 1, the velocity peak (tj + ta) <= v.
  const double way_bound = (std::sqrt(tj * tj + 4.0 / peak) - 3.0 * tj) / 2.0;
  const double ta = std::max(0.0, std::min(way_bound, v / peak - tj));
  const double cruise = peak * (tj + ta);
  const double tv = std::max(0.0, 1.0 / cruise - 2.0 * tj - ta);

  const Segment all[] = {{tj, j}, {ta, 0}, {tj, -j}, {tv, 0}, {tj, -j}, {ta, 0}, {tj, j}};
  // Pieces that are only rounding (below a part in 1e12 of the whole) are left out; the way that they would cover is
  // far below the tolerance of the end.
  const double least = 1e-12 * (4 * tj + 2 * ta + tv);
  std::vector<Segment> segments;
  for (const Segment& segment : all) {
    if (segment.duration_s > least) segments.push_back(segment);
  }
  return {std::move(segments), {}};
}

TimeLaw TimeLaw::stretched(double factor) const {
  std::vector<Segment> segments = segments_;
  for (Segment& segment : segments) {
    segment.duration_s *= factor;
    segment.jerk /= factor * factor * factor;
  }
  return {std::move(segments), {.ds = begin_.ds / factor, .dds = begin_.dds / (factor * factor)}};
}

TimeLaw TimeLaw::rest_from(double tau) const {
  if (!(tau < duration())) return {};
  const LawPoint here = at(tau);
  const double left = 1.0 - here.s;
  if (!(left > 0.0)) return {};
  std::vector<Segment> rest = segments_between(tau, duration());
  for (Segment& segment : rest) segment.jerk /= left;
  return {std::move(rest), {.ds = here.ds / left, .dds = here.dds / left}};
}

std::vector<TimeLaw::Segment> TimeLaw::segments_between(double from, double to) const {
  std::vector<Segment> between;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const double begin = std::max(from, knots_[i].tau), end = std::min(to, knots_[i + 1].tau);
    if (begin < end) between.push_back({.duration_s = end - begin, .jerk = segments_[i].jerk});
  }
  return between;
}

LawPoint TimeLaw::at(double tau) const {
  if (!(tau < duration())) return {.s = 1.0};
  if (tau < 0.0) return {};
  auto knot = std::upper_bound(knots_.begin(), knots_.end(), tau, [](double t, const Knot& k) { return t < k.tau; });
  --knot;
  LawPoint point = advanced(knot->point, tau - knot->tau);
  point.s = std::clamp(point.s, 0.0, 1.0);
  return point;
}

nlohmann::ordered_json to_json(const TimeLaw& law) {
  auto json = nlohmann::ordered_json::array();
  for (const auto& [duration, jerk] : law.segments()) json.push_back({duration, jerk});
  if (!law.begins_in_motion()) return json;
  return {{"begin", {law.begin().ds, law.begin().dds}}, {"pieces", std::move(json)}};
}

namespace {

Result<std::vector<TimeLaw::Segment>> segments_from_json(const nlohmann::ordered_json& json,
                                                         const std::string& pointer) {
  const std::string form = "a list of [duration in s, jerk in 1/s^3]";
  if (!json.is_array()) return failure(Code::kWrongType, pointer, "a time law is not a list", form);
  Diagnostics diagnostics;
  std::vector<TimeLaw::Segment> segments;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const auto& entry = json[i];
    if (!entry.is_array() || entry.size() != 2 || !entry[0].is_number() || !entry[1].is_number()) {
      diagnostics.error(Code::kWrongType, pointer + pointer_segment(i),
                        "a segment of a time law is not a pair of numbers", form);
    } else {
      segments.push_back({entry[0].get<double>(), entry[1].get<double>()});
    }
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return segments;
}

}  // namespace

Result<TimeLaw> time_law_from_json(const nlohmann::ordered_json& json, const std::string& pointer) {
  TimeLaw::Begin begin;
  const nlohmann::ordered_json* pieces = &json;
  std::string place = pointer;
  if (json.is_object()) {
    Diagnostics diagnostics;
    ObjectReader reader(json, pointer, diagnostics);
    const auto numbers = reader.numbers("begin", 2);
    pieces = reader.array("pieces");
    reader.finish();
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    begin = {.ds = numbers[0], .dds = numbers[1]};
    place += "/pieces";
  }
  auto segments = segments_from_json(*pieces, place);
  if (!segments) return std::unexpected(std::move(segments.error()));
  auto law = TimeLaw::create(std::move(*segments), begin);
  if (law) return law;
  Diagnostics diagnostics;
  diagnostics.append(law.error(), pointer);
  return std::unexpected(std::move(diagnostics));
}

}  // namespace takt::motion
