#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <span>

namespace takt::record {

/// A polynomial as a Chebyshev series over [-1, 1], of degree 6 at most. Realtime: any.
class ChebyshevSeries {
 public:
  static constexpr std::size_t kMost = 7;

  ChebyshevSeries() = default;
  /// Through `values` at the Chebyshev points of their number, from -1 to 1, both ends included.
  static ChebyshevSeries through(std::span<const double> values);
  /// T_k.
  static ChebyshevSeries basis(std::size_t k);
  /// At the Chebyshev point `k` of `count`.
  [[nodiscard]] static double point(std::size_t k, std::size_t count);

  [[nodiscard]] double operator()(double u) const;
  /// The integral from -1 on.
  [[nodiscard]] ChebyshevSeries integral() const;
  void add(double factor, const ChebyshevSeries& other);

 private:
  std::array<double, kMost> c_{};
  std::size_t count_ = 1;
};

}  // namespace takt::record
