#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace takt::record {

/// A polynomial over some samples that follow one another at equal times: by its values, in whole steps, at the
/// Chebyshev points of its degree, both ends included. Of a rate the values are rates, and the curve is their integral
/// from `start` on.
struct Piece {
  std::size_t samples = 1;
  std::vector<std::int64_t> values = {};  ///< degree + 1 of them; none: null
  std::int64_t start = 0;
};

/// A curve as pieces. Steps are powers of ten, so that the file states them exactly.
struct PieceCurve {
  int exponent = 0;                       ///< of the step of values
  std::optional<int> rate_exponent = {};  ///< of the step of rates; set: the pieces are of rates
  std::int64_t period = 0;                ///< ns between two samples; of rates only
  std::vector<Piece> pieces = {};
};

/// The most values of a piece.
inline constexpr std::size_t kMostPieceValues = 6;

/// Pieces that stay within `tolerance` (above 0) of every sample; null (NaN) stays null. Nothing: values are not finite
/// or too large for the tolerance. Cost: O(n log n). Realtime: setup.
[[nodiscard]] std::optional<PieceCurve> fit_pieces(std::span<const double> values, double tolerance);
/// The same for a curve and its rate at once, without null: one set of pieces for both.
[[nodiscard]] std::optional<PieceCurve> fit_rate_pieces(std::span<const double> values, std::span<const double> rates,
                                                        std::int64_t period, double tolerance, double rate_tolerance);

/// The values at all samples. Of rates: their integral.
[[nodiscard]] std::vector<double> values_of(const PieceCurve& curve);
/// The rates at all samples of a curve of rates.
[[nodiscard]] std::vector<double> rates_of(const PieceCurve& curve);

/// Pieces as text of digits, letters, '-' and '_': small numbers are short, and equal pieces give equal texts.
[[nodiscard]] std::string to_text(const PieceCurve& curve);
/// Reads `curve.pieces` from such a text. @return false: it is no text of pieces of `samples` samples in all
[[nodiscard]] bool read_pieces(std::string_view text, std::size_t samples, PieceCurve& curve);

}  // namespace takt::record
