#include "core/base/read_parts.h"

#include <fmt/format.h>

namespace takt {

std::string read_name(ObjectReader& reader, const std::string& fallback) {
  if (!reader.has("name")) return reader.text("name", fallback);
  const std::string given = reader.text("name");
  return given.empty() ? fallback : given;
}

Eigen::Vector3d read_direction(ObjectReader& reader, std::string_view key, const Eigen::Vector3d& fallback) {
  const Eigen::Vector3d given = reader.vector(key, fallback);
  constexpr double kShortest = 1e-9, kLongest = 1e9;
  const double length = given.stableNorm();
  if (length > kShortest && length < kLongest) return given;
  if (length <= kShortest) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at(key), "a direction of no length",
                               "Give a vector that is not zero");
  } else {
    reader.diagnostics().error(Code::kOutOfRange, reader.at(key), fmt::format("a direction of length {:.3g}", length),
                               fmt::format("Choose at most {:g}", kLongest));
  }
  return fallback;
}

}  // namespace takt
