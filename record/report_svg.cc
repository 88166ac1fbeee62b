// The pictures of the report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/utf8.h"
#include "core/base/xml_text.h"
#include "record/curves.h"
#include "record/report_parts.h"

namespace takt::record {

namespace {

constexpr double kWidth = 1000.0, kLeft = 64.0, kRight = 12.0;
constexpr double kCurveHeight = 210.0, kDifferenceHeight = 64.0, kGap = 44.0, kTop = 22.0;
constexpr std::string_view kColorA = "#d9480f", kColorB = "#1f6feb", kColorTube = "#9cc3ff";

/// A strip of the picture with its two scales.
struct Strip {
  double top, height;
  double time_low, time_high, low, high;
  [[nodiscard]] double x(double time) const {
    return kLeft + (time - time_low) / (time_high - time_low) * (kWidth - kLeft - kRight);
  }
  [[nodiscard]] double y(double value) const { return top + (high - value) / (high - low) * height; }
};

/// About `count` round numbers between low and high.
std::vector<double> ticks(double low, double high, int count) {
  const double raw = (high - low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw) {
      step = factor * power;
      break;
    }
  }
  std::vector<double> found;
  for (double n = std::ceil(low / step); n * step <= high + 1e-9 * step; n += 1.0) found.push_back(n * step);
  return found;
}

std::string tick_text(double value, double span) {
  return fmt::format("{:.4g}", std::abs(value) < 1e-9 * span ? 0.0 : value);
}

void take_range(const std::vector<double>& values, double& low, double& high) {
  for (const double value : values) {
    if (std::isnan(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
}

/// Never flat, with air above and below.
void widen(double& low, double& high, double least) {
  if (!(low <= high)) low = high = 0.0;
  const double air = std::max(0.08 * (high - low), least);
  low -= air;
  high += air;
}

/// A line through points, in tenths of the picture's units: steps are shorter to write than places.
class Pen {
 public:
  void lift() { down_ = false; }
  void go(double x, double y) {
    const long to_x = std::lround(10.0 * x), to_y = std::lround(10.0 * y);
    if (!down_) {
      path_ += fmt::format("M{:g} {:g}", 0.1 * static_cast<double>(to_x), 0.1 * static_cast<double>(to_y));
    } else if (to_x != x_ || to_y != y_) {
      path_ += fmt::format("l{:g} {:g}", 0.1 * static_cast<double>(to_x - x_), 0.1 * static_cast<double>(to_y - y_));
    }
    x_ = to_x;
    y_ = to_y;
    down_ = true;
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  long x_ = 0, y_ = 0;
  bool down_ = false;
};

/// What belongs to the axis of time moves when somebody zooms; what is beside it stays.
struct Picture {
  std::string beside, moving;
};

std::string path_of(const PlotCurve& curve, const Strip& strip) {
  Pen pen;
  for (std::size_t i = 0; i < curve.time_s.size(); ++i)
    std::isnan(curve.value[i]) ? pen.lift() : pen.go(strip.x(curve.time_s[i]), strip.y(curve.value[i]));
  return pen.path();
}

void add_axes(Picture& picture, const Strip& strip, int rows, bool with_time) {
  const double right = kWidth - kRight, bottom = strip.top + strip.height;
  picture.beside +=
      fmt::format(R"(<rect x="{}" y="{:.1f}" width="{}" height="{:.1f}" fill="#fcfcfd" stroke="#e4e7ec"/>)", kLeft,
                  strip.top, right - kLeft, strip.height);
  for (const double value : ticks(strip.low, strip.high, rows)) {
    const double y = strip.y(value);
    picture.beside +=
        fmt::format(R"(<path d="M{} {:.1f}H{}" stroke="#eceef2"/><text x="{}" y="{:.1f}" text-anchor="end">{}</text>)",
                    kLeft, y, right, kLeft - 6, y + 4, tick_text(value, strip.high - strip.low));
  }
  for (const double time : ticks(strip.time_low, strip.time_high, 10)) {
    const double x = strip.x(time);
    picture.moving += fmt::format(R"(<path d="M{:.1f} {:.1f}V{:.1f}" stroke="#eceef2"/>)", x, strip.top, bottom);
    if (!with_time) continue;
    picture.beside += fmt::format(R"(<text class="time" x="{:.1f}" y="{:.1f}" text-anchor="middle">{} s</text>)", x,
                                  bottom + 16, tick_text(time, strip.time_high - strip.time_low));
  }
}

/// Dashed lines where steps begin, with their names, each as far as the room to the next one reaches.
void add_steps(std::string& svg, const std::vector<StepMark>& steps, const Strip& strip) {
  constexpr double kLetter = 6.0, kLeast = 24.0;
  const double right = kWidth - kRight;
  double free_from = kLeft;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double x = strip.x(steps[i].time_s);
    if (x < kLeft || x > right || x < free_from) continue;
    double end = right;
    for (std::size_t next = i + 1; next < steps.size() && end == right; ++next)
      if (const double at = strip.x(steps[next].time_s); at >= x + kLeast) end = std::min(end, at);
    svg +=
        fmt::format(R"(<path d="M{:.1f} {}v{}" stroke="#98a2b3" stroke-dasharray="3 3"/>)", x, strip.top, strip.height);
    const auto letters = static_cast<std::size_t>(std::max(0.0, (end - x - 4.0) / kLetter));
    const std::string& name = steps[i].name;
    svg += fmt::format(R"(<text x="{:.1f}" y="{:.1f}">{}<title>{}</title></text>)", x + 3.0, strip.top + 12.0,
                       xml_text(name.size() <= letters ? name : std::string(cut_utf8(name, letters))), xml_text(name));
    free_from = x + kLeast;
  }
}

std::vector<Nanoseconds> to_nanoseconds(const std::vector<double>& seconds) {
  std::vector<Nanoseconds> times;
  for (const double s : seconds) times.push_back(static_cast<Nanoseconds>(std::llround(s * 1e9)));
  return times;
}

/// The tube as the union of boxes around the reference: drawn as a broad line plus the freedom in value.
void add_tube(std::string& svg, const ColumnComparison& c, const Strip& strip) {
  constexpr double kSeen = 0.4;  // half the width of a line: a narrower tube is not seen beside it
  const double half = c.tolerance.dv / (strip.high - strip.low) * strip.height;
  if (c.tolerance.kind != ToleranceKind::kTube || half < kSeen) return;
  const PlotCurve& b = c.curve_b.time_s.empty() ? c.curve_a : c.curve_b;
  const auto times = to_nanoseconds(b.time_s);
  const std::size_t count = times.size();
  // The bounds at each drawn time: least and greatest value of the reference within dt.
  const auto bounds = [&](std::size_t i) {
    double low = b.value[i], high = b.value[i];
    for (std::size_t k = i; k-- > 0 && times[k] >= times[i] - c.tolerance.dt;) {
      low = std::fmin(low, b.value[k]);
      high = std::fmax(high, b.value[k]);
    }
    for (std::size_t k = i + 1; k < count && times[k] <= times[i] + c.tolerance.dt; ++k) {
      low = std::fmin(low, b.value[k]);
      high = std::fmax(high, b.value[k]);
    }
    return std::pair(low - c.tolerance.dv, high + c.tolerance.dv);
  };
  const auto clipped = [&](double value) { return std::clamp(strip.y(value), strip.top, strip.top + strip.height); };
  for (std::size_t start = 0; start < count;) {
    if (std::isnan(b.value[start])) {
      ++start;
      continue;
    }
    Pen pen;
    std::vector<std::pair<double, double>> lower;
    std::size_t i = start;
    for (; i < count && !std::isnan(b.value[i]); ++i) {
      const auto [low, high] = bounds(i);
      pen.go(strip.x(b.time_s[i]), clipped(high));
      lower.emplace_back(strip.x(b.time_s[i]), clipped(low));
    }
    for (auto at = lower.rbegin(); at != lower.rend(); ++at) pen.go(at->first, at->second);
    svg += fmt::format(R"(<path d="{}Z" fill="{}" fill-opacity="0.4"/>)", pen.path(), kColorTube);
    start = i;
  }
}

/// A minus B at the times of A.
PlotCurve difference_of(const ColumnComparison& c) {
  PlotCurve difference;
  const auto times_a = to_nanoseconds(c.curve_a.time_s), times_b = to_nanoseconds(c.curve_b.time_s);
  for (std::size_t i = 0; i < times_a.size(); ++i) {
    difference.time_s.push_back(c.curve_a.time_s[i]);
    difference.value.push_back(c.curve_a.value[i] - value_at({times_b, c.curve_b.value}, times_a[i]));
  }
  return difference;
}

void add_difference(Picture& picture, const ColumnComparison& c, const Strip& curves) {
  const PlotCurve difference = difference_of(c);
  Strip strip{curves.top + curves.height + kGap, kDifferenceHeight, curves.time_low, curves.time_high, 0.0, 0.0};
  take_range(difference.value, strip.low, strip.high);
  const bool tube = c.tolerance.kind == ToleranceKind::kTube;
  widen(strip.low, strip.high, tube ? 1.3 * c.tolerance.dv : 1e-12);
  add_axes(picture, strip, 3, false);
  if (tube && c.tolerance.dv > 0.0) {
    picture.moving +=
        fmt::format(R"(<rect x="{}" y="{:.1f}" width="{}" height="{:.1f}" fill="{}" fill-opacity="0.4"/>)", kLeft,
                    strip.y(c.tolerance.dv), kWidth - kLeft - kRight,
                    strip.y(-c.tolerance.dv) - strip.y(c.tolerance.dv), kColorTube);
  }
  picture.moving +=
      fmt::format(R"(<path d="{}" fill="none" stroke="#344054" stroke-width="1.2"/>)", path_of(difference, strip));
  picture.beside += fmt::format(R"(<text x="{}" y="{:.1f}">A - B at equal times</text>)", kLeft, strip.top - 6);
}

void add_legend(std::string& svg, bool has_b, bool tube) {
  double x = kLeft;
  const auto add = [&](std::string_view color, std::string_view text, double width) {
    svg += fmt::format(R"(<path d="M{} 10h22" stroke="{}" stroke-width="{}"/><text x="{}" y="14">{}</text>)", x, color,
                       width, x + 28, text);
    x += 52.0 + 6.5 * static_cast<double>(text.size());
  };
  if (!has_b) return add(kColorA, "A and B", 2.0);
  add(kColorA, "A", 2.0);
  add(kColorB, "B, the reference", 2.0);
  if (tube) add(kColorTube, "tolerance around B", 8.0);
}

}  // namespace

std::string draw_column(const ColumnComparison& c, const std::vector<StepMark>& steps) {
  const bool has_b = !c.curve_b.time_s.empty();
  Strip strip{kTop, kCurveHeight, c.curve_a.time_s.front(), c.curve_a.time_s.back(), 0.0, 0.0};
  strip.low = std::numeric_limits<double>::infinity();
  strip.high = -strip.low;
  take_range(c.curve_a.value, strip.low, strip.high);
  if (has_b) {
    take_range(c.curve_b.value, strip.low, strip.high);
    strip.time_low = std::min(strip.time_low, c.curve_b.time_s.front());
    strip.time_high = std::max(strip.time_high, c.curve_b.time_s.back());
  }
  if (!(strip.time_high > strip.time_low)) strip.time_high = strip.time_low + 1e-3;
  const bool tube = has_b && c.tolerance.kind == ToleranceKind::kTube;
  widen(strip.low, strip.high, tube ? 1.3 * c.tolerance.dv : 1e-9 + 1e-3 * std::abs(strip.high));

  const double height = kTop + kCurveHeight + kGap + (has_b ? kDifferenceHeight + 8.0 : 0.0);
  Picture picture;
  add_legend(picture.beside, has_b, tube);
  add_axes(picture, strip, 5, true);
  add_steps(picture.moving, steps, strip);
  if (has_b) {
    add_tube(picture.moving, c, strip);
    picture.moving += fmt::format(R"(<path class="b" d="{}" fill="none" stroke="{}" stroke-width="2"/>)",
                                  path_of(c.curve_b, strip), kColorB);
  }
  picture.moving += fmt::format(R"(<path class="a" d="{}" fill="none" stroke="{}" stroke-width="1.4"/>)",
                                path_of(c.curve_a, strip), kColorA);
  if (has_b && !c.passed && std::isfinite(c.a)) {
    picture.moving +=
        fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="5" fill="none" stroke="#c0362c" stroke-width="2"/>)",
                    strip.x(to_seconds(c.time)), strip.y(c.a));
  }
  if (has_b) add_difference(picture, c, strip);
  // What the script needs to turn places into times and values.
  const std::string scale =
      fmt::format(R"(data-time="{:.9g} {:.9g}" data-value="{:.9g} {:.9g}" data-strip="{} {}" data-unit="{}")",
                  strip.time_low, strip.time_high, strip.low, strip.high, strip.top, strip.height, xml_text(c.unit));
  return fmt::format(R"(<svg class="plot" viewBox="0 0 {} {}" role="img" aria-label="curves over time" {}>{})"
                     R"(<svg class="window" x="{}" y="0" width="{}" height="{}" viewBox="{} 0 {} {}" )"
                     R"(preserveAspectRatio="none">{}</svg></svg>)",
                     kWidth, height, scale, picture.beside, kLeft, kWidth - kLeft - kRight, height, kLeft,
                     kWidth - kLeft - kRight, height, picture.moving);
}

}  // namespace takt::record
