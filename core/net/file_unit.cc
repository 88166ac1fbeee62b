#include "core/net/file_unit.h"

#include <cassert>
#include <numbers>
#include <string>

namespace takt::net {
namespace {

constexpr std::string_view kDegree = "deg";

}  // namespace

FileUnit file_unit(std::string_view text) {
  if (text.empty()) return {};
  std::string si(text);
  FileUnit unit;
  // Degrees are the one unit of files that is not SI; they only occur as the first factor.
  if (text.starts_with(kDegree)) {
    si.replace(0, kDegree.size(), "rad");
    unit.si_per_unit = std::numbers::pi / 180.0;
    unit.units_per_si = 180.0 / std::numbers::pi;
  }
  const auto terms = parse_unit(si);
  assert(terms && terms->size() == 1 && terms->front().variables.empty());
  unit.dimension = terms->front().dimension;
  return unit;
}

std::string key_suffix(std::string_view unit) {
  if (unit.empty() || unit == "1") return {};
  std::string suffix = "_";
  for (const char c : unit) {
    if (c == '^') continue;
    suffix += c == '/' ? '_' : c;
  }
  return suffix;
}

}  // namespace takt::net
