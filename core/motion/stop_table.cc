#include "core/motion/stop_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::motion {
namespace {

/// Of each limit: the rest is for what a quantity does between two nodes of the path.
constexpr double kStopShare = 0.98;
/// Of the jerk that the path leaves at full rate: what curvature may take while the arm brakes.
constexpr double kShareOfCurvature = 0.8;
/// Of a jerk limit, where the path alone takes all of it.
constexpr double kLeastJerk = 0.1;

StopCell stricter(const StopCell& a, const StopCell& b, double s_end) {
  return {.s_end = s_end,
          .deceleration = std::min(a.deceleration, b.deceleration),
          .deceleration_at_full_rate = std::min(a.deceleration_at_full_rate, b.deceleration_at_full_rate),
          .product = std::min(a.product, b.product),
          .jerk = std::min(a.jerk, b.jerk),
          .jerk_by_cube = std::max(a.jerk_by_cube, b.jerk_by_cube),
          .jerk_by_product = std::max(a.jerk_by_product, b.jerk_by_product)};
}

/// Largest D at full rate: the path itself may slow a quantity down, or help to.
double deceleration_of(const StopLoad& load, double fastest) {
  const double square = fastest * fastest;
  const double limit = kStopShare * load.acceleration, across = load.across * square;
  if (across >= limit) return 0.0;
  return std::max(0.0, (std::sqrt(limit * limit - across * across) + load.along * square) / load.first);
}

/// Largest product of D and r for which curvature leaves a stop a share of the jerk.
double product_of(const StopLoad& load, double fastest, double third) {
  const double second = std::hypot(load.along, load.across);
  const double left = std::max(kStopShare * load.jerk - third, kLeastJerk * load.jerk);
  return second > 0.0 ? kShareOfCurvature * left / (3.0 * second * fastest) : std::numeric_limits<double>::infinity();
}

}  // namespace

StopCell stop_cell(std::span<const StopLoad> loads, double fastest, double s_end) {
  StopCell cell{.s_end = s_end};
  const double cube = fastest * fastest * fastest;
  for (const StopLoad& load : loads) {
    cell.product = std::min(cell.product, product_of(load, fastest, load.third * cube));
    if (!(load.first > 0.0)) continue;
    cell.deceleration = std::min(cell.deceleration, kStopShare * load.acceleration / load.first);
    cell.deceleration_at_full_rate = std::min(cell.deceleration_at_full_rate, deceleration_of(load, fastest));
  }
  cell.deceleration_at_full_rate = std::min(cell.deceleration_at_full_rate, cell.deceleration);
  cell.product = std::min(cell.product, cell.deceleration);

  // The least jerk over the loads is concave in r^3 and r D: a plane that is below it at the corners of their ranges is
  // below it everywhere.
  double at_rest = std::numeric_limits<double>::infinity(), at_rate = at_rest, braking = at_rest, both = at_rest;
  for (const StopLoad& load : loads) {
    if (!(load.first > 0.0) || !std::isfinite(load.jerk)) continue;
    const double limit = kStopShare * load.jerk, third = load.third * cube;
    const double curvature = 3.0 * std::hypot(load.along, load.across) * fastest * cell.product;
    at_rest = std::min(at_rest, limit / load.first);
    at_rate = std::min(at_rate, (limit - third) / load.first);
    braking = std::min(braking, (limit - curvature) / load.first);
    both = std::min(both, (limit - third - curvature) / load.first);
  }
  cell.jerk = at_rest;
  if (!std::isfinite(at_rest)) return cell;
  cell.jerk_by_cube = at_rest - at_rate;
  cell.jerk_by_product = std::max(at_rest - braking, at_rate - both) / cell.product;
  return cell;
}

StopTable common(const StopTable& a, const StopTable& b) {
  StopTable both;
  for (std::size_t i = 0, k = 0; i < a.size() && k < b.size();) {
    const double s_end = std::min(a[i].s_end, b[k].s_end);
    both.push_back(stricter(a[i], b[k], s_end));
    const bool ends_here = a[i].s_end <= s_end;
    if (b[k].s_end <= s_end) ++k;
    if (ends_here) ++i;
  }
  return both;
}

StopTable simplified(const StopTable& table) {
  constexpr double kAlike = 0.96;
  const auto values = [](const StopCell& cell) {
    return std::array{
        cell.deceleration, cell.deceleration_at_full_rate, cell.product,
        cell.jerk,         cell.jerk - cell.jerk_by_cube,  cell.jerk - cell.jerk_by_product * cell.product};
  };
  // What a cell loses to its neighbours adds up, so it is compared with the best that is merged into it.
  std::array<double, 6> best{};
  StopTable result;
  for (const StopCell& cell : table) {
    const auto own = values(cell);
    if (!result.empty()) {
      const StopCell merged = stricter(result.back(), cell, cell.s_end);
      const auto after = values(merged);
      bool alike = true;
      for (std::size_t i = 0; i < own.size(); ++i) alike = alike && after[i] >= kAlike * std::max(own[i], best[i]);
      if (alike) {
        result.back() = merged;
        for (std::size_t i = 0; i < own.size(); ++i) best[i] = std::max(own[i], best[i]);
        continue;
      }
    }
    result.push_back(cell);
    best = own;
  }
  return result;
}

void append(StopTable& table, const StopTable& part, double s_end) {
  const double begin = table.empty() ? 0.0 : table.back().s_end;
  const double width = s_end - begin;
  for (const StopCell& cell : part) {
    table.push_back({.s_end = cell.s_end == 1.0 ? s_end : begin + width * cell.s_end,
                     .deceleration = width * cell.deceleration,
                     .deceleration_at_full_rate = width * cell.deceleration_at_full_rate,
                     .product = width * cell.product,
                     .jerk = width * cell.jerk,
                     .jerk_by_cube = width * cell.jerk_by_cube,
                     .jerk_by_product = cell.jerk_by_product});
  }
}

nlohmann::ordered_json to_json(const StopTable& table) {
  auto json = nlohmann::ordered_json::array();
  for (const StopCell& cell : table) {
    json.push_back({cell.s_end, cell.deceleration, cell.deceleration_at_full_rate, cell.product, cell.jerk,
                    cell.jerk_by_cube, cell.jerk_by_product});
  }
  return json;
}

Result<StopTable> stop_table_from_json(const nlohmann::ordered_json& json, const std::string& pointer) {
  const std::string form =
      "a list of [s_end, deceleration, deceleration_at_full_rate, product, jerk, jerk_by_cube, jerk_by_product], s_end "
      "rising to 1";
  constexpr std::size_t kNumbers = 7;
  if (!json.is_array()) return failure(Code::kWrongType, pointer, "a stop table is not a list", form);
  StopTable table;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const auto& entry = json[i];
    const bool numbers = entry.is_array() && entry.size() == kNumbers &&
                         std::ranges::all_of(entry, [](const auto& value) { return value.is_number(); });
    const std::string place = pointer + pointer_segment(i);
    if (!numbers)
      return failure(Code::kWrongType, place,
                     fmt::format("a cell of a stop table is not a list of {} numbers", kNumbers), form);
    const auto value = [&entry](std::size_t k) { return entry[k].template get<double>(); };
    table.push_back({.s_end = value(0),
                     .deceleration = value(1),
                     .deceleration_at_full_rate = value(2),
                     .product = value(3),
                     .jerk = value(4),
                     .jerk_by_cube = value(5),
                     .jerk_by_product = value(6)});
    const StopCell& cell = table.back();
    const bool positive = cell.deceleration > 0.0 && cell.product > 0.0 && cell.jerk > 0.0;
    if (!positive)
      return failure(Code::kOutOfRange, place, "a cell of a stop table has a bound that is not above 0", form);
    if (!(cell.s_end > (i == 0 ? 0.0 : table[i - 1].s_end)))
      return failure(Code::kOutOfRange, place, fmt::format("a cell of a stop table ends at s = {}", cell.s_end), form);
  }
  if (!table.empty() && table.back().s_end != 1.0)
    return failure(Code::kOutOfRange, pointer, fmt::format("a stop table ends at s = {}", table.back().s_end), form);
  return table;
}

}  // namespace takt::motion
