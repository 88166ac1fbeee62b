#include "record/chebyshev.h"

#include <algorithm>
#include <cmath>

namespace takt::record {

double ChebyshevSeries::point(std::size_t k, std::size_t count) {
  if (count < 2) return 0.0;
  return -std::cos(std::numbers::pi * static_cast<double>(k) / static_cast<double>(count - 1));
}

ChebyshevSeries ChebyshevSeries::basis(std::size_t k) {
  ChebyshevSeries series;
  series.count_ = k + 1;
  series.c_[k] = 1.0;
  return series;
}

ChebyshevSeries ChebyshevSeries::through(std::span<const double> values) {
  ChebyshevSeries series;
  const std::size_t n = values.size();
  series.count_ = n;
  if (n == 1) series.c_[0] = values[0];
  if (n < 2) return series;
  // The discrete cosine transform of the values; both ends count half.
  const auto degree = static_cast<double>(n - 1);
  for (std::size_t j = 0; j < n; ++j) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double weight = k == 0 || k == n - 1 ? 0.5 : 1.0;
      // T_j at the point k, which is -cos(pi k / degree).
      sum += weight * values[k] *
             std::cos(std::numbers::pi * static_cast<double>(j) * (1.0 - static_cast<double>(k) / degree));
    }
    series.c_[j] = sum * (j == 0 || j == n - 1 ? 1.0 : 2.0) / degree;
  }
  return series;
}

double ChebyshevSeries::operator()(double u) const {
  double next = 0.0, after = 0.0;  // Clenshaw's recurrence
  for (std::size_t k = count_; k-- > 1;) {
    const double value = 2.0 * u * next - after + c_[k];
    after = next;
    next = value;
  }
  return u * next - after + c_[0];
}

ChebyshevSeries ChebyshevSeries::integral() const {
  ChebyshevSeries series;
  series.count_ = std::min(count_ + 1, kMost);
  const auto c = [this](std::size_t k) { return k < count_ ? c_[k] : 0.0; };
  for (std::size_t k = 1; k < series.count_; ++k)
    series.c_[k] = ((k == 1 ? 2.0 : 1.0) * c(k - 1) - c(k + 1)) / (2.0 * static_cast<double>(k));
  series.c_[0] = -series(-1.0);
  return series;
}

void ChebyshevSeries::add(double factor, const ChebyshevSeries& other) {
  count_ = std::max(count_, other.count_);
  for (std::size_t k = 0; k < other.count_; ++k) c_[k] += factor * other.c_[k];
}

}  // namespace takt::record
