#include "cell/faults/fault_kind.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cell/file/description.h"

namespace takt::cell {
namespace {

Nanoseconds nanoseconds(double seconds) { return static_cast<Nanoseconds>(std::llround(1e9 * seconds)); }

}  // namespace

Nanoseconds FaultReader::duration(double absent) { return nanoseconds(number("seconds", absent)); }
Nanoseconds FaultReader::time(std::string_view key) { return nanoseconds(number(key)); }

std::string FaultReader::device(std::string_view key, std::string_view what, const std::vector<std::string>& names) {
  std::string name = text(key);
  if (!name.empty() && std::ranges::find(names, name) == names.end())
    diagnostics().error(Code::kUnknownName, at(key), fmt::format("there is no {} '{}'", what, name),
                        nearest_choice(name, names));
  return name;
}

Key duration_key(std::string meaning) {
  return number_key("seconds", "s", {.low = 0.0, .high = kLongestRun, .low_open = true}, "Duration.")
      .optional(std::move(meaning));
}

}  // namespace takt::cell
