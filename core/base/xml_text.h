#pragma once

#include <string>
#include <string_view>

namespace takt {

/// A text as it may stand between the tags, or inside a quoted attribute, of XML, SVG and HTML: the four marks of the
/// language as entities, control characters but line breaks as blanks. Any thread. Realtime: setup.
[[nodiscard]] std::string xml_text(std::string_view text);

}  // namespace takt
