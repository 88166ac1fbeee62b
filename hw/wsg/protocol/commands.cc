#include "hw/wsg/protocol/commands.h"

#include <array>
#include <iterator>

namespace takt::hw::wsg {
namespace {

constexpr double kPerMetre = 1000.0;  // the interface counts in mm
constexpr std::uint8_t kRelative = 1, kStopOnBlock = 2;
constexpr std::uint8_t kAutoOn = 1, kOnChangeOnly = 2;

constexpr std::string_view kStatusNames[] = {"success",
                                             "not available",
                                             "no sensor",
                                             "not initialized",
                                             "already running",
                                             "not supported",
                                             "inconsistent data",
                                             "timeout",
                                             "read error",
                                             "write error",
                                             "no memory",
                                             "checksum error",
                                             "no parameter expected",
                                             "not enough parameters",
                                             "unknown command",
                                             "format error",
                                             "access denied",
                                             "already open",
                                             "failed",
                                             "aborted",
                                             "invalid handle",
                                             "not found",
                                             "not open",
                                             "I/O error",
                                             "invalid parameter",
                                             "index out of bounds",
                                             "pending",
                                             "overrun",
                                             "out of range",
                                             "axis blocked",
                                             "file exists"};

double scale_of(Command command) {
  return command == Command::kSetForce || command == Command::kGetForce || command == Command::kForce ? 1.0 : kPerMetre;
}

void append_scaled(std::string& out, double value, double scale) { append(out, static_cast<float>(value * scale)); }

}  // namespace

std::string_view name_of(Status status) {
  const auto i = static_cast<std::size_t>(status);
  return i < std::size(kStatusNames) ? kStatusNames[i] : "unknown status";
}

std::optional<Answer> parse_answer(std::string_view payload) {
  PayloadReader reader(payload);
  const auto status = static_cast<Status>(reader.take<std::uint16_t>());
  if (!reader.whole()) return std::nullopt;
  return Answer{status, payload.substr(sizeof(std::uint16_t))};
}

void append_answer(std::string& out, Command command, Status status, std::string_view parameters) {
  std::string payload;
  append(payload, static_cast<std::uint16_t>(status));
  if (status == Status::kSuccess) payload += parameters;
  append_packet(out, static_cast<std::uint8_t>(command), payload);
}

std::string motion_payload(Command command, const Motion& motion) {
  std::string payload;
  if (command == Command::kMove)
    append(payload,
           static_cast<std::uint8_t>((motion.relative ? kRelative : 0) | (motion.stop_on_block ? kStopOnBlock : 0)));
  append_scaled(payload, motion.width, kPerMetre);
  append_scaled(payload, motion.speed, kPerMetre);
  return payload;
}

std::optional<Motion> parse_motion(Command command, std::string_view payload) {
  PayloadReader reader(payload);
  Motion motion;
  if (command == Command::kMove) {
    const auto flags = reader.take<std::uint8_t>();
    motion.relative = (flags & kRelative) != 0;
    motion.stop_on_block = (flags & kStopOnBlock) != 0;
  }
  motion.width = reader.take_float() / kPerMetre;
  motion.speed = reader.take_float() / kPerMetre;
  if (!reader.whole() || reader.left() > 0) return std::nullopt;
  return motion;
}

std::string auto_update_payload(const AutoUpdate& update) {
  std::string payload;
  append(payload, static_cast<std::uint8_t>((update.on ? kAutoOn : 0) | (update.on_change_only ? kOnChangeOnly : 0)));
  append(payload, update.period_ms);
  return payload;
}

std::optional<AutoUpdate> parse_auto_update(std::string_view payload) {
  PayloadReader reader(payload);
  const auto flags = reader.take<std::uint8_t>();
  const auto period_ms = reader.take<std::uint16_t>();
  if (!reader.whole() || reader.left() > 0) return std::nullopt;
  return AutoUpdate{(flags & kAutoOn) != 0, (flags & kOnChangeOnly) != 0, period_ms};
}

std::string number_payload(Command command, double value) {
  std::string payload;
  append_scaled(payload, value, scale_of(command));
  return payload;
}

std::optional<double> parse_number(Command command, std::string_view payload) {
  PayloadReader reader(payload);
  const double value = reader.take_float();
  if (!reader.whole() || reader.left() > 0) return std::nullopt;
  return value / scale_of(command);
}

std::string limits_payload(const Limits& limits) {
  std::string payload;
  for (const double x :
       {limits.stroke, limits.speed_min, limits.speed_max, limits.acceleration_min, limits.acceleration_max})
    append_scaled(payload, x, kPerMetre);
  for (const double x : {limits.force_min, limits.force_nominal, limits.force_overdrive})
    append_scaled(payload, x, 1.0);
  return payload;
}

std::optional<Limits> parse_limits(std::string_view payload) {
  PayloadReader reader(payload);
  Limits limits;
  for (double* x :
       {&limits.stroke, &limits.speed_min, &limits.speed_max, &limits.acceleration_min, &limits.acceleration_max})
    *x = reader.take_float() / kPerMetre;
  for (double* x : {&limits.force_min, &limits.force_nominal, &limits.force_overdrive}) *x = reader.take_float();
  if (!reader.whole() || reader.left() > 0) return std::nullopt;
  return limits;
}

}  // namespace takt::hw::wsg
