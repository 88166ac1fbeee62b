#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/random.h"

namespace takt::test {

/// What a fuzz program tries. Its file defines fuzz_target(); fuzz_target.cc hands it to libFuzzer.
struct FuzzTarget {
  std::vector<std::string> words;        ///< that its input is made of
  void (*load)(std::string_view input);  ///< ends the process if a promise does not hold
  double share;                          ///< of the inputs that `mutate` changes; the others get changed bytes
  /// Changes an input as what it is; nothing: it is not of that form.
  std::optional<std::string> (*mutate)(std::string_view input, Random& random);
};
[[nodiscard]] const FuzzTarget& fuzz_target();

}  // namespace takt::test
