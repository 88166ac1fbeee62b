#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/net/flat_net.h"

namespace takt::net {

/// One name in the frame text of a port.
struct FrameName {
  enum class Kind { kVariable, kParameter, kLiteral };
  Kind kind = Kind::kLiteral;
  std::string_view text;  ///< the letter, the parameter's name, the name itself
};

/// The names of "A>B", "@base>flange", "A"; none for an empty text.
/// @return std::nullopt if a name is empty, or an "@" names no String parameter of the type.
[[nodiscard]] std::optional<std::vector<FrameName>> parse_frame_names(std::string_view text, const PrimitiveInfo& info);

/// Unifies the frame names over all links (row U2): reports each link whose ends name different frames. A parameter
/// with an empty text is a variable. Realtime: setup, near linear.
void check_frames(const FlatNet& flat, LoadReport& report);

}  // namespace takt::net
