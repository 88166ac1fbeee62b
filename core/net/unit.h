#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt::net {

/// A fraction in lowest terms. A result beyond 10^9 is not valid (denominator 0), and so is what is made of it.
struct Rational {
  std::int32_t numerator = 0, denominator = 1;

  friend Rational operator+(const Rational& a, const Rational& b);
  friend Rational operator-(const Rational& a, const Rational& b);
  friend Rational operator*(const Rational& a, const Rational& b);
  friend Rational operator/(const Rational& a, const Rational& b);  ///< b is not 0
  friend Rational operator-(const Rational& a) { return {-a.numerator, a.denominator}; }
  bool operator==(const Rational&) const = default;
  [[nodiscard]] bool zero() const { return numerator == 0 && valid(); }
  [[nodiscard]] bool valid() const { return denominator != 0; }
};

/// Exponents over m, kg, s, A, K, rad (row U1).
struct Dimension {
  std::array<Rational, 6> exponent{};

  bool operator==(const Dimension&) const = default;
  [[nodiscard]] bool valid() const;
  [[nodiscard]] bool zero() const { return *this == Dimension{}; }
  /// this * other^power
  [[nodiscard]] Dimension times(const Dimension& other, const Rational& power = {1, 1}) const;
};

/// "m/s^2", "N", "1", ...: named units where they fit exactly.
[[nodiscard]] std::string to_string(const Dimension& dimension);

/// A unit text with variables: dimension times powers of variables, a lower-case letter each ("u*v", "u/s", "m/s^2").
struct UnitTerm {
  Dimension dimension;
  std::vector<std::pair<char, Rational>> variables;  ///< sorted, without zeros
};

/// Reads a unit text: factors joined by '*' and '/', each a base unit, N, Nm, J, W, Pa, V, Hz, 1 or a variable, with an
/// optional exponent ("s^2", "u^1/2"). "linear,angular" gives two terms, an empty text none.
/// @return std::nullopt if the text is malformed.
[[nodiscard]] std::optional<std::vector<UnitTerm>> parse_unit(std::string_view text);

}  // namespace takt::net
