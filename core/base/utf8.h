#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace takt {

/// The longest beginning of `text` with at most `max_bytes` bytes that ends between two characters of UTF-8.
/// Realtime: cyclic, constant time.
[[nodiscard]] std::string_view cut_utf8(std::string_view text, std::size_t max_bytes);

/// `text` is UTF-8: no stray or missing bytes, no overlong forms, no surrogates. Realtime: cyclic, O(n).
[[nodiscard]] bool is_utf8(std::string_view text);

/// `text` with U+FFFD in place of every byte that is not part of a UTF-8 character. Realtime: setup.
[[nodiscard]] std::string to_valid_utf8(std::string_view text);

/// What a device said, fit for one line of a terminal: control characters and DEL as "\x1b", every byte that is not
/// part of a UTF-8 character as U+FFFD. Realtime: setup.
[[nodiscard]] std::string escape_controls(std::string_view text);

}  // namespace takt
