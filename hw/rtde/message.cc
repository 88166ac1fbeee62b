#include "hw/rtde/message.h"

#include <algorithm>

namespace takt::hw::rtde {

namespace {

constexpr std::size_t kLongestText = 255;

void append_short_text(std::string& bytes, std::string_view text) {
  const std::string_view kept = text.substr(0, kLongestText);
  append(bytes, static_cast<std::uint8_t>(kept.size()));
  bytes.append(kept);
}

}  // namespace

std::string encode(const TextMessage& message, int protocol) {
  std::string payload;
  if (protocol >= 2) {
    append_short_text(payload, message.text);
    append_short_text(payload, message.source);
    append(payload, static_cast<std::uint8_t>(message.level));
  } else {
    append(payload, static_cast<std::uint8_t>(message.level));
    payload.append(message.text.substr(0, kLongestText));
  }
  return make_package(PackageType::kText, payload);
}

std::optional<TextMessage> decode_text(std::string_view payload, int protocol) {
  ByteReader reader(payload);
  TextMessage message;
  if (protocol >= 2) {
    message.text = reader.take_text(reader.take<std::uint8_t>());
    message.source = reader.take_text(reader.take<std::uint8_t>());
    message.level = static_cast<TextMessage::Level>(reader.take<std::uint8_t>());
  } else {
    message.level = static_cast<TextMessage::Level>(reader.take<std::uint8_t>());
    message.text = reader.take_rest();
  }
  if (!reader.ok()) return std::nullopt;
  return message;
}

std::string encode_output_request(double frequency, std::string_view names, int protocol) {
  std::string payload;
  if (protocol >= 2) append(payload, frequency);
  payload.append(names);
  return make_package(PackageType::kSetupOutputs, payload);
}

std::optional<OutputRequest> decode_output_request(std::string_view payload, int protocol) {
  ByteReader reader(payload);
  OutputRequest request;
  if (protocol >= 2) request.frequency = reader.take<double>();
  request.names = split_names(reader.take_rest());
  if (!reader.ok()) return std::nullopt;
  return request;
}

std::string encode_setup_reply(PackageType type, std::uint8_t id, std::string_view words, bool with_id) {
  std::string payload;
  if (with_id) append(payload, id);
  payload.append(words);
  return make_package(type, payload);
}

std::optional<SetupReply> decode_setup_reply(std::string_view payload, bool with_id) {
  ByteReader reader(payload);
  SetupReply reply;
  reply.id = with_id ? reader.take<std::uint8_t>() : 1;
  reply.words = split_names(reader.take_rest());
  if (!reader.ok()) return std::nullopt;
  return reply;
}

std::string encode_version(const Version& version) {
  std::string payload;
  for (const std::uint32_t part : {version.major, version.minor, version.bugfix, version.build}) append(payload, part);
  return make_package(PackageType::kControllerVersion, payload);
}

std::optional<Version> decode_version(std::string_view payload) {
  ByteReader reader(payload);
  Version version;
  for (std::uint32_t* part : {&version.major, &version.minor, &version.bugfix, &version.build})
    *part = reader.take<std::uint32_t>();
  if (!reader.ok()) return std::nullopt;
  return version;
}

std::size_t Recipe::size(const FieldTable& table) const {
  std::size_t bytes = 0;
  for (const FieldTable::Id field : fields) bytes += wire_size(table[field].type);
  return bytes;
}

}  // namespace takt::hw::rtde
