#include "tools/robustness/strip_plot.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace takt::tools {
namespace {

// Pixels.
constexpr double kWidth = 420.0, kHeight = 30.0, kEdge = 8.0, kAxis = 15.0, kDot = 4.0;
/// Dots go up and down in turn, so that equal values stay visible.
constexpr double kStagger = 4.0;

/// Values to pixels. Everything that is drawn fits.
class Scale {
 public:
  explicit Scale(const ExpectationSpread& expectation) {
    const Spread spread = expectation.spread();
    low_ = std::min({spread.least, expectation.lower.value_or(spread.least), expectation.upper.value_or(spread.least)});
    high_ = std::max({spread.greatest, expectation.upper.value_or(spread.greatest), expectation.lower.value_or(low_)});
    if (low_ > 0.0 && low_ < 0.5 * high_) low_ = 0.0;  // an axis from zero shows how much of a bound is used
    if (high_ - low_ < 1e-12 * std::max(1.0, std::abs(high_))) high_ = low_ + 1.0;
  }
  [[nodiscard]] double pixel(double value) const {
    return kEdge + (kWidth - 2.0 * kEdge) * (value - low_) / (high_ - low_);
  }

 private:
  double low_ = 0.0, high_ = 1.0;
};

std::string vertical(double x, const char* color, double width, const std::string& title) {
  return fmt::format(R"(<line x1="{0:.1f}" x2="{0:.1f}" y1="2" y2="{1:.0f}" stroke="{2}" stroke-width="{3}">)"
                     R"(<title>{4}</title></line>)",
                     x, kHeight - 2.0, color, width, title);
}

}  // namespace

std::string strip_plot(const ExpectationSpread& expectation) {
  const Scale scale(expectation);
  std::string svg = fmt::format(R"(<svg viewBox="0 0 {:.0f} {:.0f}" role="img">)", kWidth, kHeight);
  svg += fmt::format(R"(<line x1="{0:.1f}" x2="{1:.1f}" y1="{2:.1f}" y2="{2:.1f}" stroke="#e4e7ec" stroke-width="2"/>)",
                     kEdge, kWidth - kEdge, kAxis);
  for (const auto& bound : {expectation.lower, expectation.upper})
    if (bound) svg += vertical(scale.pixel(*bound), "#c0362c", 2.0, "bound: " + amount_text(*bound, expectation.unit));
  const double median = expectation.spread().median;
  svg += vertical(scale.pixel(median), "#98a2b3", 1.0, "median: " + amount_text(median, expectation.unit));
  int place = 0;
  for (const auto& one : expectation.judged) {
    if (!one.value) continue;
    const double y = kAxis + kStagger * static_cast<double>(place++ % 3 - 1);
    svg += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}" fill="{}" fill-opacity="0.75">)"
                       R"(<title>seed {}: {}</title></circle>)",
                       scale.pixel(*one.value), y, kDot, one.passed ? "#16794c" : "#c0362c", one.seed,
                       amount_text(*one.value, expectation.unit));
  }
  return svg + "</svg>";
}

}  // namespace takt::tools
