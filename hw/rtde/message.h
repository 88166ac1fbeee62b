#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hw/rtde/field.h"
#include "hw/rtde/package.h"

/// What the payloads of RTDE packages say, for both ends.
namespace takt::hw::rtde {

/// A text message, from either end.
struct TextMessage {
  enum class Level : std::uint8_t { kException = 0, kError = 1, kWarning = 2, kInfo = 3 };
  Level level = Level::kInfo;
  std::string text;    ///< at most 255 bytes go over the wire
  std::string source;  ///< likewise; protocol 1 has none
};
/// The whole package. @param protocol  1 or 2
[[nodiscard]] std::string encode(const TextMessage& message, int protocol);
/// @return nothing if the payload is too short for what it announces.
[[nodiscard]] std::optional<TextMessage> decode_text(std::string_view payload, int protocol);

/// A request to set up outputs. Protocol 1 has no frequency: 0.
struct OutputRequest {
  double frequency = 0.0;  ///< Hz
  std::vector<std::string_view> names;
};
[[nodiscard]] std::string encode_output_request(double frequency, std::string_view names, int protocol);
[[nodiscard]] std::optional<OutputRequest> decode_output_request(std::string_view payload, int protocol);

/// The answer to a request for outputs or inputs: words that stand for the fields in their order.
struct SetupReply {
  std::uint8_t id = 0;  ///< of the recipe; 0: it is not valid
  std::vector<std::string_view> words;
};
inline constexpr std::string_view kNotFound = "NOT_FOUND", kInUse = "IN_USE";
/// @param with_id  false: answers for outputs in protocol 1
[[nodiscard]] std::string encode_setup_reply(PackageType type, std::uint8_t id, std::string_view words, bool with_id);
[[nodiscard]] std::optional<SetupReply> decode_setup_reply(std::string_view payload, bool with_id);

/// The answer to GET_URCONTROL_VERSION.
[[nodiscard]] std::string encode_version(const Version& version);
[[nodiscard]] std::optional<Version> decode_version(std::string_view payload);

/// Fields in the order of a set-up, with their types.
struct Recipe {
  std::uint8_t id = 0;
  std::vector<FieldTable::Id> fields;
  /// Bytes of all values. Realtime: cyclic.
  [[nodiscard]] std::size_t size(const FieldTable& table) const;
};

}  // namespace takt::hw::rtde
