#include "record/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "record/chebyshev.h"

namespace takt::record {
namespace {

constexpr double kNullValue = std::numeric_limits<double>::quiet_NaN();
/// Samples that a fit looks at; all of them are checked.
constexpr std::size_t kFitSamples = 48;
constexpr double kLargestStep = 1e12;  ///< in steps: sums stay whole in a double

double power_of_ten(int exponent) { return exponent < 0 ? 1.0 / std::pow(10.0, -exponent) : std::pow(10.0, exponent); }

/// The greatest power of ten that is at most a fifth of the tolerance: rounding leaves most of it to the curve.
int exponent_for(double tolerance) { return static_cast<int>(std::floor(std::log10(0.2 * tolerance))); }

/// A sample of a piece, from -1 to 1.
double place_of(std::size_t i, std::size_t samples) {
  return samples < 2 ? -1.0 : 2.0 * static_cast<double>(i) / static_cast<double>(samples - 1) - 1.0;
}

/// The polynomial of a piece, in units.
ChebyshevSeries series_of(const Piece& piece, double step) {
  std::array<double, kMostPieceValues> values{};
  for (std::size_t k = 0; k < piece.values.size(); ++k) values[k] = step * static_cast<double>(piece.values[k]);
  return ChebyshevSeries::through(std::span(values).first(piece.values.size()));
}

/// How long a piece lasts from its first sample to its last, over the length of [-1, 1]: what an integral is times.
double half_span(const Piece& piece, std::int64_t period) {
  return 0.5e-9 * static_cast<double>(period) * static_cast<double>(piece.samples - 1);
}

constexpr std::size_t kMostUnknowns = kMostPieceValues + 1;
using Row = std::array<double, kMostUnknowns>;

/// Least squares by normal equations: rows are added, then solved by Cholesky's decomposition.
class LeastSquares {
 public:
  explicit LeastSquares(std::size_t unknowns) : n_(unknowns) {}

  void add(const Row& row, double right) {
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t k = 0; k <= i; ++k) a_[i][k] += row[i] * row[k];
      b_[i] += row[i] * right;
    }
  }
  /// @return false: the rows do not say
  bool solve(Row& x) {
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t k = 0; k <= i; ++k) {
        double sum = a_[i][k];
        for (std::size_t m = 0; m < k; ++m) sum -= a_[i][m] * a_[k][m];
        if (i == k && !(sum > 1e-12 * a_[i][i])) return false;
        a_[i][k] = i == k ? std::sqrt(sum) : sum / a_[k][k];
      }
    }
    for (std::size_t i = 0; i < n_; ++i) {
      x[i] = b_[i];
      for (std::size_t m = 0; m < i; ++m) x[i] -= a_[i][m] * x[m];
      x[i] /= a_[i][i];
    }
    for (std::size_t i = n_; i-- > 0;) {
      for (std::size_t m = i + 1; m < n_; ++m) x[i] -= a_[m][i] * x[m];
      x[i] /= a_[i][i];
    }
    return true;
  }

 private:
  std::size_t n_;
  std::array<Row, kMostUnknowns> a_{};
  Row b_{};
};

/// Fits one piece to samples and checks it.
class PieceFitter {
 public:
  virtual ~PieceFitter() = default;
  /// A piece of `count` values over the samples from `from` on; nothing: it does not hold.
  [[nodiscard]] virtual std::optional<Piece> fit(std::size_t from, std::size_t samples, std::size_t count) const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual bool is_null(std::size_t) const { return false; }
};

/// T_0 to T_6 at `u`.
Row basis_at(double u) {
  Row row{1.0, u};
  for (std::size_t j = 2; j < row.size(); ++j) row[j] = 2.0 * u * row[j - 1] - row[j - 2];
  return row;
}

/// The samples that a fit of `samples` looks at: evenly, with both ends.
std::size_t fit_sample(std::size_t i, std::size_t chosen, std::size_t samples) {
  return chosen < 2 ? 0 : i * (samples - 1) / (chosen - 1);
}

class ValueFitter final : public PieceFitter {
 public:
  ValueFitter(std::span<const double> values, double tolerance, double step)
      : values_(values), tolerance_(tolerance), step_(step) {}

  [[nodiscard]] std::size_t size() const override { return values_.size(); }
  [[nodiscard]] bool is_null(std::size_t i) const override { return std::isnan(values_[i]); }

  [[nodiscard]] std::optional<Piece> fit(std::size_t from, std::size_t samples, std::size_t count) const override {
    const auto part = values_.subspan(from, samples);
    if (count == 1) return constant(part);
    if (samples < count) return std::nullopt;
    LeastSquares system(count);
    const std::size_t chosen = std::min(samples, kFitSamples);
    for (std::size_t i = 0; i < chosen; ++i) {
      const std::size_t k = fit_sample(i, chosen, samples);
      system.add(basis_at(place_of(k, samples)), part[k]);
    }
    Row c{};
    if (!system.solve(c)) return std::nullopt;
    ChebyshevSeries fitted;
    for (std::size_t j = 0; j < count; ++j) fitted.add(c[j], ChebyshevSeries::basis(j));
    Piece piece{.samples = samples};
    for (std::size_t k = 0; k < count; ++k)
      piece.values.push_back(std::llround(fitted(ChebyshevSeries::point(k, count)) / step_));
    return holds(piece, part) ? std::optional(piece) : std::nullopt;
  }

 private:
  [[nodiscard]] std::optional<Piece> constant(std::span<const double> part) const {
    const auto [least, greatest] = std::ranges::minmax(part);
    Piece piece{.samples = part.size(), .values = {std::llround(0.5 * (least + greatest) / step_)}};
    const double value = step_ * static_cast<double>(piece.values[0]);
    const bool inside = greatest - value <= tolerance_ && value - least <= tolerance_;
    return inside ? std::optional(piece) : std::nullopt;
  }
  [[nodiscard]] bool holds(const Piece& piece, std::span<const double> part) const {
    const ChebyshevSeries series = series_of(piece, step_);
    for (std::size_t i = 0; i < part.size(); ++i)
      if (!(std::abs(series(place_of(i, part.size())) - part[i]) <= tolerance_)) return false;
    return true;
  }

  std::span<const double> values_;
  double tolerance_, step_;
};

class RateFitter final : public PieceFitter {
 public:
  RateFitter(std::span<const double> values, std::span<const double> rates, std::int64_t period,
             std::array<double, 2> tolerances, std::array<double, 2> steps)
      : values_(values), rates_(rates), period_(period), tolerances_(tolerances), steps_(steps) {}

  [[nodiscard]] std::size_t size() const override { return values_.size(); }

  [[nodiscard]] std::optional<Piece> fit(std::size_t from, std::size_t samples, std::size_t count) const override {
    const auto values = values_.subspan(from, samples), rates = rates_.subspan(from, samples);
    if (samples < count) return std::nullopt;
    Piece piece{.samples = samples};
    if (!fit_rates(values, rates, count, piece)) return std::nullopt;
    // The start is what lets the integral of the rounded rates lie in the middle.
    const ChebyshevSeries rate = series_of(piece, steps_[1]), way = rate.integral();
    const double span = half_span(piece, period_);
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    for (std::size_t i = 0; i < samples; ++i) {
      const double u = place_of(i, samples), off = values[i] - span * way(u);
      least = std::min(least, off);
      greatest = std::max(greatest, off);
      if (greatest - least > 2.0 * tolerances_[0] || !(std::abs(rate(u) - rates[i]) <= tolerances_[1]))
        return std::nullopt;
    }
    piece.start = std::llround(0.5 * (least + greatest) / steps_[0]);
    const double start = steps_[0] * static_cast<double>(piece.start);
    const bool inside = greatest - start <= tolerances_[0] && start - least <= tolerances_[0];
    return inside ? std::optional(piece) : std::nullopt;
  }

 private:
  /// Unknowns: the start, then the series of the rate.
  bool fit_rates(std::span<const double> values, std::span<const double> rates, std::size_t count, Piece& piece) const {
    LeastSquares system(count + 1);
    const std::size_t samples = values.size(), chosen = std::min(samples, kFitSamples);
    const double span = half_span(piece, period_);
    std::array<ChebyshevSeries, kMostPieceValues> basis, integrals;
    for (std::size_t j = 0; j < count; ++j) {
      basis[j] = ChebyshevSeries::basis(j);
      integrals[j] = basis[j].integral();
    }
    for (std::size_t i = 0; i < chosen; ++i) {
      const std::size_t k = fit_sample(i, chosen, samples);
      const double u = place_of(k, samples);
      Row of_value{1.0 / tolerances_[0]}, of_rate{};
      for (std::size_t j = 0; j < count; ++j) {
        of_value[j + 1] = span * integrals[j](u) / tolerances_[0];
        of_rate[j + 1] = basis[j](u) / tolerances_[1];
      }
      system.add(of_value, (values[k] - values[0]) / tolerances_[0]);
      system.add(of_rate, rates[k] / tolerances_[1]);
    }
    Row c{};
    if (!system.solve(c)) return false;
    ChebyshevSeries fitted;
    for (std::size_t j = 0; j < count; ++j) fitted.add(c[j + 1], basis[j]);
    for (std::size_t k = 0; k < count; ++k)
      piece.values.push_back(std::llround(fitted(ChebyshevSeries::point(k, count)) / steps_[1]));
    return true;
  }

  std::span<const double> values_, rates_;
  std::int64_t period_;
  std::array<double, 2> tolerances_, steps_;
};

/// The longest piece of `count` values from `from` on, up to `end`.
std::optional<Piece> longest(const PieceFitter& fitter, std::size_t from, std::size_t end, std::size_t count) {
  const std::size_t room = end - from;
  std::optional<Piece> best = fitter.fit(from, std::min(room, count), count);
  if (!best) return best;
  std::size_t good = best->samples, bad = room + 1;
  for (std::size_t stride = 8; good < room; stride *= 2) {
    const std::size_t next = std::min(room, good + stride);
    auto longer = fitter.fit(from, next, count);
    if (!longer) {
      bad = next;
      break;
    }
    best = std::move(longer);
    good = next;
  }
  // To within a few hundredths: the last samples save nothing.
  while (bad - good > 1 + good / 32) {
    const std::size_t middle = good + (bad - good) / 2;
    if (auto longer = fitter.fit(from, middle, count)) {
      best = std::move(longer);
      good = middle;
    } else {
      bad = middle;
    }
  }
  return best;
}

/// The piece that costs least for each sample: a value is about two characters, what is around it three.
std::optional<Piece> cheapest(const PieceFitter& fitter, std::size_t from, std::size_t end) {
  std::optional<Piece> best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (std::size_t count = 1; count <= kMostPieceValues; ++count) {
    auto piece = longest(fitter, from, end, count);
    if (!piece) continue;
    const double cost = (3.0 + 2.0 * static_cast<double>(count)) / static_cast<double>(piece->samples);
    if (cost >= best_cost) continue;
    best_cost = cost;
    best = std::move(piece);
    if (best->samples == end - from) break;
  }
  return best;
}

std::optional<std::vector<Piece>> fit_all(const PieceFitter& fitter) {
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < fitter.size();) {
    std::size_t end = i + 1;
    const bool null = fitter.is_null(i);
    while (end < fitter.size() && fitter.is_null(end) == null) ++end;
    if (null) {
      pieces.push_back({.samples = end - i});
      i = end;
      continue;
    }
    while (i < end) {
      auto piece = cheapest(fitter, i, end);
      if (!piece) return std::nullopt;
      i += piece->samples;
      pieces.push_back(std::move(*piece));
    }
  }
  return pieces;
}

/// Whether whole steps can count the values.
bool fits_steps(std::span<const double> values, double step, bool allow_null) {
  return std::ranges::all_of(values,
                             [&](double v) { return std::isnan(v) ? allow_null : std::abs(v) <= kLargestStep * step; });
}

constexpr std::string_view kDigits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_";

/// Five bits a character, the least first; the sixth says that more follow.
void add_digits(std::string& text, std::uint64_t number) {
  for (; number >= 32; number >>= 5) text += kDigits[32 + (number & 31)];
  text += kDigits[number];
}

/// Signs go to the least bit, so that small numbers are short whatever their sign.
void add_signed(std::string& text, std::int64_t number) {
  add_digits(text, (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63));
}

class NumberReader {
 public:
  explicit NumberReader(std::string_view text) : rest_(text) {}
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] bool ok() const { return ok_; }

  std::uint64_t get() {
    std::uint64_t number = 0;
    for (int shift = 0; ok_; shift += 5) {
      const std::size_t digit = rest_.empty() ? std::string_view::npos : kDigits.find(rest_.front());
      ok_ = digit != std::string_view::npos && shift < 60;
      if (!ok_) break;
      rest_.remove_prefix(1);
      number |= static_cast<std::uint64_t>(digit & 31) << shift;
      if (digit < 32) break;
    }
    return number;
  }
  std::int64_t get_signed() {
    const std::uint64_t number = get();
    return static_cast<std::int64_t>(number >> 1) ^ -static_cast<std::int64_t>(number & 1);
  }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

/// Of a header: how many values a piece has, below its number of samples.
constexpr std::size_t kHeader = kMostPieceValues + 1;

}  // namespace

std::optional<PieceCurve> fit_pieces(std::span<const double> values, double tolerance) {
  if (!(tolerance > 0.0)) return std::nullopt;
  PieceCurve curve{.exponent = exponent_for(tolerance)};
  const double step = power_of_ten(curve.exponent);
  if (!fits_steps(values, step, true)) return std::nullopt;
  auto pieces = fit_all(ValueFitter(values, tolerance, step));
  if (!pieces) return std::nullopt;
  curve.pieces = std::move(*pieces);
  return curve;
}

std::optional<PieceCurve> fit_rate_pieces(std::span<const double> values, std::span<const double> rates,
                                          std::int64_t period, double tolerance, double rate_tolerance) {
  if (!(tolerance > 0.0) || !(rate_tolerance > 0.0) || values.size() != rates.size()) return std::nullopt;
  PieceCurve curve{
      .exponent = exponent_for(tolerance), .rate_exponent = exponent_for(rate_tolerance), .period = period};
  const std::array<double, 2> steps{power_of_ten(curve.exponent), power_of_ten(*curve.rate_exponent)};
  if (!fits_steps(values, steps[0], false) || !fits_steps(rates, steps[1], false)) return std::nullopt;
  auto pieces = fit_all(RateFitter(values, rates, period, {tolerance, rate_tolerance}, steps));
  if (!pieces) return std::nullopt;
  curve.pieces = std::move(*pieces);
  return curve;
}

std::vector<double> values_of(const PieceCurve& curve) {
  std::vector<double> values;
  const double step = power_of_ten(curve.exponent);
  for (const Piece& piece : curve.pieces) {
    if (piece.values.empty()) {
      values.insert(values.end(), piece.samples, kNullValue);
      continue;
    }
    if (!curve.rate_exponent) {
      const ChebyshevSeries series = series_of(piece, step);
      for (std::size_t i = 0; i < piece.samples; ++i) values.push_back(series(place_of(i, piece.samples)));
      continue;
    }
    const ChebyshevSeries way = series_of(piece, power_of_ten(*curve.rate_exponent)).integral();
    const double start = step * static_cast<double>(piece.start), span = half_span(piece, curve.period);
    for (std::size_t i = 0; i < piece.samples; ++i) values.push_back(start + span * way(place_of(i, piece.samples)));
  }
  return values;
}

std::vector<double> rates_of(const PieceCurve& curve) {
  PieceCurve rates{.exponent = curve.rate_exponent.value_or(0), .pieces = curve.pieces};
  return values_of(rates);
}

std::string to_text(const PieceCurve& curve) {
  std::string text;
  std::int64_t last = 0, start = 0;
  for (const Piece& piece : curve.pieces) {
    add_digits(text, piece.samples * kHeader + piece.values.size());
    if (curve.rate_exponent && !piece.values.empty()) {
      add_signed(text, piece.start - start);
      start = piece.start;
    }
    for (const std::int64_t value : piece.values) {
      add_signed(text, value - last);
      last = value;
    }
  }
  return text;
}

bool read_pieces(std::string_view text, std::size_t samples, PieceCurve& curve) {
  constexpr std::int64_t kMost = std::int64_t{1} << 50;
  NumberReader reader(text);
  std::int64_t last = 0, start = 0;
  curve.pieces.clear();
  while (!reader.at_end()) {
    const std::uint64_t header = reader.get();
    Piece piece{.samples = header / kHeader};
    if (!reader.ok() || piece.samples == 0 || piece.samples > samples) return false;
    samples -= piece.samples;
    const std::size_t count = header % kHeader;
    if (curve.rate_exponent && count > 0) piece.start = start += reader.get_signed();
    for (std::size_t k = 0; k < count; ++k) piece.values.push_back(last += reader.get_signed());
    if (!reader.ok() || std::abs(last) > kMost || std::abs(start) > kMost) return false;
    curve.pieces.push_back(std::move(piece));
  }
  return samples == 0;
}

}  // namespace takt::record
