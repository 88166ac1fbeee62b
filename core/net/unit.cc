#include "core/net/unit.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <map>
#include <numeric>

#include <fmt/format.h>

namespace takt::net {
namespace {

constexpr std::int64_t kLargest = 1'000'000'000;

Rational reduced(std::int64_t numerator, std::int64_t denominator) {
  if (denominator < 0) {
    numerator = -numerator;
    denominator = -denominator;
  }
  const std::int64_t divisor = std::gcd(numerator, denominator);
  if (divisor > 1) {
    numerator /= divisor;
    denominator /= divisor;
  }
  if (numerator > kLargest || numerator < -kLargest || denominator > kLargest) return {1, 0};
  return {static_cast<std::int32_t>(numerator), static_cast<std::int32_t>(denominator)};
}

struct NamedUnit {
  std::string_view name;
  std::array<int, 6> exponent;  ///< m, kg, s, A, K, rad
};

/// The first name that fits is the one that is printed.
constexpr std::array kUnits = {
    NamedUnit{"1", {0, 0, 0, 0, 0, 0}},    NamedUnit{"m", {1, 0, 0, 0, 0, 0}},
    NamedUnit{"kg", {0, 1, 0, 0, 0, 0}},   NamedUnit{"s", {0, 0, 1, 0, 0, 0}},
    NamedUnit{"A", {0, 0, 0, 1, 0, 0}},    NamedUnit{"K", {0, 0, 0, 0, 1, 0}},
    NamedUnit{"rad", {0, 0, 0, 0, 0, 1}},  NamedUnit{"N", {1, 1, -2, 0, 0, 0}},
    NamedUnit{"Nm", {2, 1, -2, 0, 0, 0}},  NamedUnit{"J", {2, 1, -2, 0, 0, 0}},
    NamedUnit{"W", {2, 1, -3, 0, 0, 0}},   NamedUnit{"Pa", {-1, 1, -2, 0, 0, 0}},
    NamedUnit{"V", {2, 1, -3, -1, 0, 0}},  NamedUnit{"Hz", {0, 0, -1, 0, 0, 0}},
    NamedUnit{"N/m", {0, 1, -2, 0, 0, 0}}, NamedUnit{"Nm/rad", {2, 1, -2, 0, 0, -1}},
};

Dimension dimension_of(const NamedUnit& unit) {
  Dimension dimension;
  for (std::size_t i = 0; i < 6; ++i) dimension.exponent[i] = {unit.exponent[i], 1};
  return dimension;
}

std::optional<Rational> parse_exponent(std::string_view text) {
  std::int64_t parts[2] = {0, 1};
  const std::size_t slash = text.find('/');
  const std::string_view words[2] = {text.substr(0, slash),
                                     slash == std::string_view::npos ? "1" : text.substr(slash + 1)};
  for (int i = 0; i < 2; ++i) {
    const auto [end, error] = std::from_chars(words[i].data(), words[i].data() + words[i].size(), parts[i]);
    if (error != std::errc{} || end != words[i].data() + words[i].size()) return std::nullopt;
  }
  if (parts[1] <= 0 || std::abs(parts[0]) > kLargest || parts[1] > kLargest) return std::nullopt;
  return reduced(parts[0], parts[1]);
}

bool is_variable(std::string_view name) {
  return name.size() == 1 && name[0] >= 'a' && name[0] <= 'z' && name != "m" && name != "s";
}

/// Multiplies `term` by name^power.
bool apply(std::string_view name, const Rational& power, UnitTerm& term) {
  if (is_variable(name)) {
    term.variables.emplace_back(name[0], power);
    return true;
  }
  const auto unit = std::ranges::find(kUnits, name, &NamedUnit::name);
  if (unit == kUnits.end()) return false;
  term.dimension = term.dimension.times(dimension_of(*unit), power);
  return true;
}

void collect(std::vector<std::pair<char, Rational>>& variables) {
  std::map<char, Rational> sums;
  for (const auto& [name, power] : variables) sums[name] = sums[name] + power;
  variables.clear();
  for (const auto& [name, power] : sums) {
    if (!power.zero()) variables.emplace_back(name, power);
  }
}

/// An exponent's own '/' stands directly between two digits after '^'.
std::size_t factor_end(std::string_view text, std::size_t start) {
  bool in_exponent = false;
  for (std::size_t i = start; i < text.size(); ++i) {
    if (text[i] == '^') in_exponent = true;
    if (text[i] == '*') return i;
    if (text[i] != '/') continue;
    const bool fraction = in_exponent && i + 1 < text.size() && text[i + 1] >= '0' && text[i + 1] <= '9';
    if (!fraction) return i;
    in_exponent = false;
  }
  return text.size();
}

std::optional<UnitTerm> parse_term(std::string_view text) {
  UnitTerm term;
  bool divides = false;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = factor_end(text, start);
    const std::string_view factor = text.substr(start, end - start);
    const std::size_t caret = factor.find('^');
    Rational power{1, 1};
    if (caret != std::string_view::npos) {
      const auto exponent = parse_exponent(factor.substr(caret + 1));
      if (!exponent) return std::nullopt;
      power = *exponent;
    }
    if (divides) power = -power;
    if (!apply(factor.substr(0, caret), power, term)) return std::nullopt;
    if (end == text.size()) break;
    divides = text[end] == '/';
    start = end + 1;
  }
  collect(term.variables);
  return term;
}

std::string power_text(std::string_view name, const Rational& power) {
  if (power == Rational{1, 1}) return std::string(name);
  if (power.denominator == 1) return fmt::format("{}^{}", name, power.numerator);
  return fmt::format("{}^{}/{}", name, power.numerator, power.denominator);
}

}  // namespace

Rational operator+(const Rational& a, const Rational& b) {
  if (!a.valid() || !b.valid()) return {1, 0};
  const std::int64_t x = a.numerator, y = b.numerator;
  return reduced(x * b.denominator + y * a.denominator, std::int64_t{a.denominator} * b.denominator);
}
Rational operator-(const Rational& a, const Rational& b) { return a + -b; }
Rational operator*(const Rational& a, const Rational& b) {
  if (!a.valid() || !b.valid()) return {1, 0};
  return reduced(std::int64_t{a.numerator} * b.numerator, std::int64_t{a.denominator} * b.denominator);
}
Rational operator/(const Rational& a, const Rational& b) {
  if (!a.valid() || !b.valid()) return {1, 0};
  return reduced(std::int64_t{a.numerator} * b.denominator, std::int64_t{a.denominator} * b.numerator);
}

bool Dimension::valid() const {
  return std::ranges::all_of(exponent, [](const Rational& e) { return e.valid(); });
}

Dimension Dimension::times(const Dimension& other, const Rational& power) const {
  if (other.zero()) return *this;
  Dimension product;
  for (std::size_t i = 0; i < 6; ++i) product.exponent[i] = exponent[i] + other.exponent[i] * power;
  return product;
}

std::string to_string(const Dimension& dimension) {
  for (const NamedUnit& unit : kUnits) {
    if (dimension == dimension_of(unit)) return std::string(unit.name);
  }
  std::string above, below;
  for (std::size_t i = 0; i < 6; ++i) {
    const Rational& e = dimension.exponent[i];
    const std::string_view name = kUnits[i + 1].name;
    if (e.numerator > 0) above += (above.empty() ? "" : "*") + power_text(name, e);
    if (e.numerator < 0) below += "/" + power_text(name, -e);
  }
  return (above.empty() ? "1" : above) + below;
}

std::optional<std::vector<UnitTerm>> parse_unit(std::string_view text) {
  std::vector<UnitTerm> terms;
  if (text.empty()) return terms;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    auto term = parse_term(text.substr(start, end - start));
    if (!term) return std::nullopt;
    terms.push_back(std::move(*term));
    start = end + 1;
  }
  if (terms.size() > 2) return std::nullopt;
  return terms;
}

}  // namespace takt::net
