#include "core/device/channel.h"

#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/unit.h"
#include "core/net/value_json.h"

namespace takt::device {
namespace {

using net::ValueType;

static_assert(std::variant_size_v<ChannelValue> == static_cast<std::size_t>(ValueType::kJoints) + 1);

bool carries_unit(ValueType type) {
  return type == ValueType::kReal || type == ValueType::kVector || type == ValueType::kTwist ||
         type == ValueType::kWrench || type == ValueType::kJoints;
}

/// Names of a frame text: two for a frame, one for what is expressed in a frame, none else.
int frame_names(ValueType type) {
  if (type == ValueType::kFrame || type == ValueType::kRotation) return 2;
  return type == ValueType::kVector || type == ValueType::kTwist || type == ValueType::kWrench ? 1 : 0;
}

void check_unit(const ChannelDescription& channel, Diagnostics& diagnostics) {
  if (channel.unit.empty()) return;
  if (!carries_unit(channel.type)) {
    diagnostics.error(Code::kConflict, "/unit",
                      fmt::format("a {} carries no unit, not '{}'", net::name_of(channel.type), channel.unit));
    return;
  }
  const auto terms = net::parse_unit(channel.unit);
  bool right = terms && !terms->empty();
  for (std::size_t i = 0; right && i < terms->size(); ++i) right = (*terms)[i].variables.empty();
  if (!right)
    diagnostics.error(Code::kInvalidValue, "/unit", fmt::format("'{}' is not a unit", channel.unit),
                      "Use a unit such as m/s, rad, N, 1");
  const bool two = channel.type == ValueType::kTwist || channel.type == ValueType::kWrench;
  if (right && terms->size() > (two ? 2u : 1u))
    diagnostics.error(Code::kInvalidValue, "/unit", fmt::format("'{}' are two units", channel.unit),
                      "Give one for all components");
}

void check_frame(const ChannelDescription& channel, Diagnostics& diagnostics) {
  if (channel.frame.empty()) return;
  const std::size_t sign = channel.frame.find('>');
  const int names = sign == std::string::npos ? 1 : 2;
  const bool whole = sign != 0 && sign + 1 != channel.frame.size() &&
                     (names == 1 || channel.frame.find('>', sign + 1) == std::string::npos);
  const int wanted = frame_names(channel.type);
  if (whole && names == wanted) return;
  diagnostics.error(Code::kInvalidValue, "/frame",
                    fmt::format("'{}' is not a frame of a {}", channel.frame, net::name_of(channel.type)),
                    wanted == 2   ? "Write 'A>B', the pose of B in A"
                    : wanted == 1 ? "Name the frame that it is expressed in"
                                  : "none");
}

}  // namespace

std::string_view Channel::kind_of(ValueType type) {
  static constexpr std::array<std::string_view, 10> kKinds = {
      "Boolean channel",  "Integer channel", "Real channel",  "String channel", "Vector channel",
      "Rotation channel", "Frame channel",   "Twist channel", "Wrench channel", "Joints channel"};
  return kKinds.at(static_cast<std::size_t>(type));
}

Result<std::unique_ptr<Channel>> Channel::make(const ChannelDescription& description) {
  Diagnostics diagnostics;
  if (description.name.empty()) diagnostics.error(Code::kMissing, "/name", "a channel needs a name");
  check_unit(description, diagnostics);
  check_frame(description, diagnostics);
  if (description.timeout < 0)
    diagnostics.error(Code::kOutOfRange, "/timeout", "a timeout below 0", "Give 0 for none, or a time in seconds");
  if (description.initial && description.initial->index() != static_cast<std::size_t>(description.type)) {
    diagnostics.error(Code::kTypeMismatch, "/initial",
                      fmt::format("a {}, but the channel carries a {}",
                                  net::name_of(static_cast<ValueType>(description.initial->index())),
                                  net::name_of(description.type)));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return std::unique_ptr<Channel>(new Channel(description));
}

Channel::Channel(const ChannelDescription& description)
    : Device(description.name), description_(description), signal_{description.unit, description.frame} {
  if (signal_.unit.empty() && carries_unit(description.type)) signal_.unit = "1";
  slot_size_ = net::visit_type(description.type,
                               []<class T>(std::type_identity<T>) -> std::size_t { return sizeof(net::Slot<T>); });
  for (Bytes* bytes : {&pending_, &shown_, &previous_}) set_null(description_.type, bytes->data());
  if (description_.initial) set(shown_.data(), *description_.initial);
}

void Channel::set_null(ValueType type, std::byte* bytes) {
  net::visit_type(type, [bytes]<class T>(std::type_identity<T>) { slot_in<T>(bytes).set_null(); });
}

void Channel::set(std::byte* bytes, const ChannelValue& value) {
  std::visit([bytes]<class T>(const T& given) { slot_in<T>(bytes).set(given); }, value);
}

Channel::Written Channel::write_null() {
  return write_slot(description_.type, [this](std::byte* bytes) { set_null(description_.type, bytes); });
}

Channel::Written Channel::write(const ChannelValue& value) {
  return write_slot(static_cast<ValueType>(value.index()), [&value](std::byte* bytes) { set(bytes, value); });
}

void Channel::begin_cycle(std::int64_t, Nanoseconds time) {
  if (has_pending_) {
    keep_previous(time_);
    std::memcpy(shown_.data(), pending_.data(), slot_size_);
    written_ = time_;  // of the cycle before: there it was written
  }
  latched_ = mailbox_.take([this, time](const std::byte* newest) {
    keep_previous(time);
    std::memcpy(shown_.data(), newest, slot_size_);
  });
  if (latched_) written_ = time;
  has_value_ = has_value_ || has_pending_ || latched_;
  has_pending_ = false;
  time_ = time;
  if (description_.timeout > 0 && has_value_ && time_ - written_ > description_.timeout)
    set_null(description_.type, shown_.data());
}

void Channel::keep_previous(Nanoseconds time) {
  if (!has_value_) return;
  std::memcpy(previous_.data(), shown_.data(), slot_size_);
  interval_ = time - written_;
  // A value that was null only because it had grown too old is one still, and so is one that would have.
  if (description_.timeout > 0 && interval_ > description_.timeout) set_null(description_.type, previous_.data());
}

void Channel::add_state(StateWords& words) const {
  words.add(std::uint64_t{has_value_});
  words.add(static_cast<std::int64_t>(has_value_ ? written_ : 0));
  for (std::size_t at = 0; at < slot_size_; at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, shown_.data() + at, sizeof(word));
    words.add(word);
  }
}

std::optional<Nanoseconds> Channel::age() const {
  if (!has_value_) return std::nullopt;
  return time_ - written_;
}

std::optional<ChannelValue> value_in(ValueType type, const void* slot) {
  return net::visit_type(type, [slot]<class T>(std::type_identity<T>) -> std::optional<ChannelValue> {
    net::Slot<T> copy;
    std::memcpy(static_cast<void*>(&copy), slot, sizeof(copy));
    if (copy.null != 0) return std::nullopt;
    return ChannelValue(copy.value);
  });
}

std::string to_text(const ChannelValue& value) {
  return std::visit([](const auto& given) { return net::value_to_json(given).dump(); }, value);
}

}  // namespace takt::device
