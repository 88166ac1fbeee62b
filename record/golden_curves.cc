#include "record/golden_curves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "record/curves.h"
#include "record/pieces.h"

namespace takt::record {
namespace {

constexpr std::string_view kSetPoint = "/set_point", kMeasured = "/joint_states";
constexpr std::string_view kPosition = ".position", kVelocity = ".velocity";

/// Rounding of points takes a tenth of the thinning, the lines between them the rest.
constexpr double kLineShare = 0.9, kStepShare = 0.2;

/// `value` rounded to a multiple of a power of ten of at most `step`: short to write, and within step/2.
double rounded(double value, double step) {
  if (!std::isfinite(value) || !(step > 0.0)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(step)));
  const double inverse = std::round(1.0 / unit);
  return unit < 1.0 ? std::round(value * inverse) / inverse : std::round(value / unit) * unit;
}

std::optional<GoldenGrid> grid_of(std::span<const Nanoseconds> time) {
  if (time.size() < 3) return std::nullopt;
  const GoldenGrid grid{.start = time[0], .period = time[1] - time[0], .samples = time.size()};
  for (std::size_t i = 1; i < time.size(); ++i)
    if (time[i] - time[i - 1] != grid.period) return std::nullopt;
  return grid.period > 0 ? std::optional(grid) : std::nullopt;
}

/// Which sample of a held signal counts at sample `i`, as a sample of the grid.
std::size_t held_at(std::size_t i, std::size_t every, std::size_t from) {
  return every < 2 ? i : i < from ? 0 : from + (i - from) / every * every;
}

/// Where a signal is sampled: the first sample, and then each one of the hold.
std::vector<std::size_t> held_samples(std::size_t samples, std::size_t every, std::size_t from) {
  std::vector<std::size_t> chosen;
  if (every >= 2 && from > 0 && samples > 0) chosen.push_back(0);
  for (std::size_t i = every < 2 ? 0 : from; i < samples; i += every < 2 ? 1 : every) chosen.push_back(i);
  return chosen;
}

bool same_value(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

struct Hold {
  std::size_t every = 1, from = 0;
};

/// A signal that changes only at every n-th sample is one that is sampled so often and held.
Hold find_hold(std::span<const double> values) {
  constexpr std::size_t kLeastChanges = 8;
  std::size_t every = 0, first = 0, last = 0, changes = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (same_value(values[i], values[i - 1])) continue;
    if (changes++ == 0) {
      first = i;
    } else {
      every = std::gcd(every, i - last);
    }
    if (every == 1) return {};
    last = i;
  }
  return changes < kLeastChanges ? Hold{} : Hold{.every = every, .from = first % every};
}

std::vector<double> at(std::span<const double> values, std::span<const std::size_t> samples) {
  std::vector<double> chosen;
  for (const std::size_t i : samples) chosen.push_back(values[i]);
  return chosen;
}

/// What is left of `values` at `samples` of a reference that they follow by `delay`.
std::vector<double> remainder(std::span<const double> values, std::span<const double> reference,
                              std::span<const std::size_t> samples, std::size_t delay) {
  std::vector<double> left;
  for (const std::size_t i : samples) left.push_back(values[i] - reference[i - std::min(i, delay)]);
  return left;
}

double greatest_magnitude(std::span<const double> values) {
  double greatest = 0.0;
  for (const double v : values)
    greatest = std::isnan(v) ? std::numeric_limits<double>::infinity() : std::max(greatest, std::abs(v));
  return greatest;
}

/// The delay by which `values` follow the reference best, up to 100 samples.
std::size_t find_delay(std::span<const double> values, std::span<const double> reference,
                       std::span<const std::size_t> samples) {
  constexpr std::size_t kMostDelay = 100, kMostSamples = 4000;
  std::vector<std::size_t> few;
  const std::size_t stride = samples.size() / kMostSamples + 1;
  for (std::size_t i = 0; i < samples.size(); i += stride) few.push_back(samples[i]);
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t delay = 0; delay <= kMostDelay; ++delay) {
    const double off = greatest_magnitude(remainder(values, reference, few, delay));
    if (off < least) best = delay;
    least = std::min(least, off);
  }
  return best;
}

/// The name of the column with `from` in place of `to` at its end; empty: it does not end so.
std::string renamed(std::string_view name, std::string_view from, std::string_view to) {
  if (!name.ends_with(from)) return {};
  return std::string(name.substr(0, name.size() - from.size())) + std::string(to);
}

/// Whether `rates` are the slope of `values`, within half of the tolerance.
bool is_rate(std::span<const double> values, std::span<const double> rates, Nanoseconds period, double tolerance) {
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    const double slope = (values[i + 1] - values[i - 1]) / (2e-9 * static_cast<double>(period));
    if (!(std::abs(slope - rates[i]) <= 0.5 * tolerance)) return false;
  }
  return true;
}

/// Of exact columns every sample counts, and a tolerance of zero leaves nothing to pieces.
bool may_be_curve(const Tolerance& tolerance) { return tolerance.kind != ToleranceKind::kExact && tolerance.dv > 0.0; }

}  // namespace

void GoldenWriter::put(GoldenColumn column, std::vector<double> values) {
  if (column.topic.ends_with(kSetPoint)) values_[{column.topic, column.column}] = std::move(values);
  golden_.columns.push_back(std::move(column));
}

void GoldenWriter::add_points(const Table& table, std::size_t column, GoldenColumn golden) {
  const CurveView curve{table.time, table.values[column]};
  const bool exact = golden.tolerance.kind == ToleranceKind::kExact;
  if (exact) golden.thinning = 0.0;
  std::vector<std::size_t> kept(exact ? table.time.size() : 0);
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  if (!exact) kept = thin(curve, kLineShare * golden.thinning);
  for (const std::size_t i : kept) {
    golden.time_s.push_back(static_cast<double>(curve.time[i]) / 1e9);
    golden.value.push_back(rounded(curve.value[i], kStepShare * golden.thinning));
  }
  golden_.columns.push_back(std::move(golden));
}

std::optional<GoldenCurve> GoldenWriter::curve_of(const Table& table, std::size_t column, double thinning) const {
  const std::vector<double>& values = table.values[column];
  const Hold hold = find_hold(values);
  const auto fitted = fit_pieces(at(values, held_samples(values.size(), hold.every, hold.from)), thinning);
  std::optional<GoldenCurve> curve;
  if (fitted)
    curve = GoldenCurve{
        .exponent = fitted->exponent, .pieces = to_text(*fitted), .hold_every = hold.every, .hold_from = hold.from};
  auto follower = following(table, column, thinning);
  return follower && (!curve || follower->pieces.size() < curve->pieces.size()) ? follower : curve;
}

std::optional<GoldenCurve> GoldenWriter::following(const Table& table, std::size_t column, double thinning) const {
  const std::string topic = renamed(table.topic, kMeasured, kSetPoint);
  const auto reference = values_.find({topic, table.columns[column]});
  if (topic.empty() || reference == values_.end() || golden_.grids.at(topic) != golden_.grids.at(table.topic))
    return std::nullopt;
  const std::vector<double>& values = table.values[column];
  const Hold hold = find_hold(values);
  const auto samples = held_samples(values.size(), hold.every, hold.from);
  const std::size_t delay = find_delay(values, reference->second, samples);
  const auto left = remainder(values, reference->second, samples, delay);
  GoldenCurve curve{.hold_every = hold.every,
                    .hold_from = hold.from,
                    .follows_topic = topic,
                    .follows_column = table.columns[column],
                    .delay = delay};
  if (greatest_magnitude(left) <= thinning) return curve;
  const auto fitted = fit_pieces(left, thinning);
  if (!fitted) return std::nullopt;
  curve.exponent = fitted->exponent;
  curve.pieces = to_text(*fitted);
  return curve;
}

/// A position and its velocity, if they are commanded and belong together, in one set of pieces.
bool GoldenWriter::add_with_rate(const Table& table, std::size_t column, const std::vector<Tolerance>& tolerances) {
  const std::string name = renamed(table.columns[column], kPosition, kVelocity);
  const auto found = std::ranges::find(table.columns, name);
  if (name.empty() || found == table.columns.end() || !table.topic.ends_with(kSetPoint)) return false;
  const auto rate = static_cast<std::size_t>(found - table.columns.begin());
  if (!may_be_curve(tolerances[rate]) || tolerances[rate].kind == ToleranceKind::kReportOnly) return false;
  const double thinning = share_ * tolerances[column].dv, of_rate = share_ * tolerances[rate].dv;
  const Nanoseconds period = golden_.grids.at(table.topic).period;
  if (!is_rate(table.values[column], table.values[rate], period, of_rate)) return false;
  const auto fitted = fit_rate_pieces(table.values[column], table.values[rate], period, thinning, of_rate);
  if (!fitted) return false;
  put({.topic = table.topic,
       .column = table.columns[column],
       .unit = table.units[column],
       .tolerance = tolerances[column],
       .thinning = thinning,
       .curve =
           GoldenCurve{
               .exponent = fitted->exponent, .rate_exponent = fitted->rate_exponent, .pieces = to_text(*fitted)}},
      values_of(*fitted));
  put({.topic = table.topic,
       .column = name,
       .unit = table.units[rate],
       .tolerance = tolerances[rate],
       .thinning = of_rate,
       .curve = GoldenCurve{.follows_topic = table.topic, .follows_column = table.columns[column], .rate = true}},
      rates_of(*fitted));
  return true;
}

void GoldenWriter::add(const Table& table, const std::vector<Tolerance>& tolerances) {
  const auto grid = grid_of(table.time);
  if (grid) golden_.grids[table.topic] = *grid;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const auto done = [&](const GoldenColumn& one) {
      return one.topic == table.topic && one.column == table.columns[i];
    };
    if (tolerances[i].kind == ToleranceKind::kReportOnly || std::ranges::any_of(golden_.columns, done)) continue;
    const bool is_curve = grid && may_be_curve(tolerances[i]);
    if (is_curve && add_with_rate(table, i, tolerances)) continue;
    GoldenColumn column{.topic = table.topic,
                        .column = table.columns[i],
                        .unit = table.units[i],
                        .tolerance = tolerances[i],
                        .thinning = share_ * tolerances[i].dv};
    if (is_curve) column.curve = curve_of(table, i, column.thinning);
    if (!column.curve) {
      add_points(table, i, std::move(column));
      continue;
    }
    GoldenReader reader(golden_);
    auto values = table.topic.ends_with(kSetPoint) ? reader.read(column) : std::nullopt;
    put(std::move(column), values ? std::move(values->value) : std::vector<double>());
  }
}

bool is_followed(const Golden& golden, const GoldenColumn& column) {
  return std::ranges::any_of(golden.columns, [&](const GoldenColumn& other) {
    return other.curve && other.curve->follows_column == column.column && other.curve->follows_topic == column.topic;
  });
}

std::optional<std::vector<double>> GoldenReader::values(const GoldenColumn& column) {
  const GoldenCurve& curve = *column.curve;
  const auto grid = golden_.grids.find(column.topic);
  if (grid == golden_.grids.end()) return std::nullopt;
  const std::size_t samples = grid->second.samples;
  PieceCurve own{.exponent = curve.exponent, .rate_exponent = curve.rate_exponent, .period = grid->second.period};
  if (curve.rate) {
    const auto other = std::ranges::find_if(golden_.columns, [&](const GoldenColumn& one) {
      return one.topic == curve.follows_topic && one.column == curve.follows_column && one.curve;
    });
    if (other == golden_.columns.end() || !other->curve->rate_exponent || curve.follows_topic != column.topic)
      return std::nullopt;
    own.rate_exponent = other->curve->rate_exponent;
    return read_pieces(other->curve->pieces, samples, own) ? std::optional(rates_of(own)) : std::nullopt;
  }
  const auto chosen = held_samples(samples, curve.hold_every, curve.hold_from);
  if (!curve.pieces.empty() && !read_pieces(curve.pieces, chosen.size(), own)) return std::nullopt;
  const std::vector<double> pieces = curve.pieces.empty() ? std::vector(chosen.size(), 0.0) : values_of(own);
  const std::vector<double>* reference = nullptr;
  if (!curve.follows_column.empty()) {
    const auto known = known_.find({curve.follows_topic, curve.follows_column});
    if (known == known_.end() || known->second.size() != samples) return std::nullopt;
    reference = &known->second;
  }
  std::vector<double> values(samples);
  for (std::size_t i = 0, next = 0; i < samples; ++i) {
    const std::size_t held = held_at(i, curve.hold_every, curve.hold_from);
    while (next + 1 < chosen.size() && chosen[next + 1] <= held) ++next;
    values[i] = pieces[next] + (reference != nullptr ? (*reference)[held - std::min(held, curve.delay)] : 0.0);
  }
  return values;
}

std::optional<GoldenReader::Curve> GoldenReader::read(const GoldenColumn& column) {
  Curve curve;
  if (!column.curve) {
    for (const double t : column.time_s) curve.time.push_back(static_cast<Nanoseconds>(std::llround(t * 1e9)));
    curve.value = column.value;
    return curve;
  }
  auto values = this->values(column);
  if (!values) return std::nullopt;
  const GoldenGrid& grid = golden_.grids.at(column.topic);
  for (std::size_t i = 0; i < grid.samples; ++i)
    curve.time.push_back(grid.start + static_cast<Nanoseconds>(i) * grid.period);
  curve.value = *values;
  if (is_followed(golden_, column)) known_[{column.topic, column.column}] = std::move(*values);
  return curve;
}

}  // namespace takt::record
