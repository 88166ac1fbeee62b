#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt {

/// A character of a text, both from 1; the column counts bytes.
struct TextLocation {
  int line = 1;
  int column = 1;
  bool operator==(const TextLocation&) const = default;
};

/// Where elements of a JSON document are written: for each pointer the key of the member or the first character of the
/// element, or, if the document has no such element, of the innermost one around it. A text that is not JSON has only
/// what is readable before the error.
/// Realtime: setup, O(bytes of the text).
[[nodiscard]] std::map<std::string, TextLocation, std::less<>> locate_pointers(
    std::string_view json, const std::set<std::string, std::less<>>& pointers);

/// Fills in line and column of every diagnostic that names a JSON file and a pointer into it, by reading the files
/// again. What cannot be read stays without. Realtime: setup.
void locate(Diagnostics& diagnostics);

/// All diagnostics with their locations, a line each, for people.
[[nodiscard]] std::string to_located_text(Diagnostics diagnostics);

}  // namespace takt
