#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt::test {

/// A place of the source that says what a user did wrong.
struct ErrorSite {
  std::string place;    ///< FILE:LINE
  std::string message;  ///< as it stands there, with {} for what is put in
};

/// All calls of error(), failure() and their kind in the .cc files of a folder whose message stands there as a text.
/// What is written on from elsewhere ("diagnostics.append") has its site there.
/// @param folder  from the root of the repository, in which tests run
[[nodiscard]] std::vector<ErrorSite> error_sites(const std::string& folder);

/// Is this what the site says? Anything may stand for its {}; it may stand inside of a longer text.
[[nodiscard]] bool says(const ErrorSite& site, std::string_view text);

}  // namespace takt::test
