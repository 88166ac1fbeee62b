#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"

namespace takt::test {

/// A location of the source that says what a user did wrong.
struct ErrorSite {
  std::string file;
  int line = 0;
  std::string message;       ///< as the source has it, with {} for what is filled in
  std::optional<Code> code;  ///< nothing: it is given elsewhere
};

/// All calls of error(), failure() and their kind in the .cc files of a folder whose message is a text there.
/// What is appended from elsewhere ("diagnostics.append") has its site there.
/// @param folder  from the root of the repository, in which tests run
[[nodiscard]] std::vector<ErrorSite> error_sites(const std::string& folder);

/// Is this what the site says? Anything may be filled in for its {}; it may be a part of a longer text.
[[nodiscard]] bool says(const ErrorSite& site, std::string_view text);

/// A site that no case of a test reaches, and why.
struct Excuse {
  std::string file;          ///< how its name ends
  std::optional<Code> code;  ///< nothing: of a site that has none
  std::string why;
};

/// Sites that say nothing of what was said and have no excuse, and excuses that excuse nothing; a line each.
[[nodiscard]] std::vector<std::string> unsaid(const std::vector<ErrorSite>& sites, const std::set<std::string>& said,
                                              const std::vector<Excuse>& excuses);

}  // namespace takt::test
