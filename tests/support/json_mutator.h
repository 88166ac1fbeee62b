#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/random.h"

namespace takt::test {

/// Every key and every text of a document, each once: what a mutator puts where it does not belong.
[[nodiscard]] std::vector<std::string> words_of(const nlohmann::ordered_json& document);

/// A document with one to four things changed in a way that keeps it JSON: a value lost, doubled, moved, of another
/// type, a number at an edge, a text of another place or a misspelt one. Knows nothing of what the file means.
[[nodiscard]] std::string mutated_json(const nlohmann::ordered_json& document, const std::vector<std::string>& words,
                                       Random& random);

}  // namespace takt::test
