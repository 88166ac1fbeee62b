#include "hw/fri/protocol/packet.h"

#include <bit>
#include <optional>
#include <type_traits>

namespace takt::hw::fri {
namespace {

/// Writes fields one behind the other.
class Writer {
 public:
  explicit Writer(std::span<std::byte> bytes) : bytes_(bytes) {}

  void operator()(std::uint16_t value) { put(value); }
  void operator()(std::uint32_t value) { put(value); }
  void operator()(std::int32_t value) { put(static_cast<std::uint32_t>(value)); }
  void operator()(float value) { put(std::bit_cast<std::uint32_t>(value)); }
  void operator()(double value) { (*this)(static_cast<float>(value)); }

 private:
  template <class Word>
  void put(Word value) {
    for (std::size_t i = 0; i < sizeof(Word); ++i) bytes_[next_++] = static_cast<std::byte>(value >> 8 * i & 0xff);
  }
  std::span<std::byte> bytes_;
  std::size_t next_ = 0;
};

/// Reads them in the same order.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  void operator()(std::uint16_t& value) { value = get<std::uint16_t>(); }
  void operator()(std::uint32_t& value) { value = get<std::uint32_t>(); }
  void operator()(std::int32_t& value) { value = static_cast<std::int32_t>(get<std::uint32_t>()); }
  void operator()(float& value) { value = std::bit_cast<float>(get<std::uint32_t>()); }
  void operator()(double& value) { value = std::bit_cast<float>(get<std::uint32_t>()); }

 private:
  template <class Word>
  Word get() {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < sizeof(Word); ++i) value |= std::to_integer<std::uint32_t>(bytes_[next_++]) << 8 * i;
    return static_cast<Word>(value);
  }
  std::span<const std::byte> bytes_;
  std::size_t next_ = 0;
};

// Each of the following serves both directions, so that their orders cannot differ. `Io` is Writer or Reader.

template <class Io, class Enum>
void enumeration(Io& io, Enum& value) {
  auto word = static_cast<std::uint16_t>(value);
  io(word);
  if constexpr (!std::is_const_v<Enum>) value = static_cast<Enum>(word);
}

template <class Io, class Values>
void in_order(Io& io, Values& values) {
  for (auto& value : values) io(value);
}

template <class Io, class Matrix>
void by_rows(Io& io, Matrix& matrix) {
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) io(matrix(row, column));
}

/// The upper three rows of the homogeneous matrix, row by row.
template <class Io, class Pose>
void frame(Io& io, Pose& X) {
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 4; ++column) io(X.matrix()(row, column));
}

/// Rotations come as A, B, C: about z, y, x.
constexpr std::array<Eigen::Index, 6> kAxisOrder = {0, 1, 2, 5, 4, 3};

template <class Io, class Vector>
void axes(Io& io, Vector& values) {
  for (const Eigen::Index i : kAxisOrder) io(values[i]);
}

template <class Io, class Force>
void wrench(Io& io, Force& value) {
  for (Eigen::Index i = 0; i < 3; ++i) io(value.force[i]);
  for (Eigen::Index i = 2; i >= 0; --i) io(value.torque[i]);
}

template <class Io, class Packet>
void header(Io& io, Packet& packet, std::uint16_t& size, std::uint16_t& id) {
  io(packet.sequence);
  io(packet.reflected);
  io(size);
  io(id);
}

template <class Io, class Values>
void krl(Io& io, Values& values) {
  std::uint16_t filler = 0;
  in_order(io, values.real);
  in_order(io, values.integer);
  io(values.boolean);
  io(filler);
}

template <class Io, class M>
void interface_fields(Io& io, M& m) {
  io(m.timestamp);
  enumeration(io, m.state);
  enumeration(io, m.quality);
  io(m.measurement_period);
  io(m.command_period);
  io(m.safety_limits);
  io(m.statistics.answer_rate);
  io(m.statistics.latency);
  io(m.statistics.jitter);
  io(m.statistics.miss_rate);
  io(m.statistics.misses);
}

template <class Io, class M>
void robot_fields(Io& io, M& m) {
  io(m.power);
  enumeration(io, m.control);
  io(m.error);
  io(m.warning);
  in_order(io, m.temperature);
}

template <class Io, class M>
void data_fields(Io& io, M& m) {
  in_order(io, m.q);
  frame(io, m.X_BT);
  in_order(io, m.q_before);
  in_order(io, m.q_offset);
  frame(io, m.X_BT_before);
  frame(io, m.X_offset);
  in_order(io, m.tau);
  in_order(io, m.tau_external);
  wrench(io, m.wrench_external);
  for (const Eigen::Index row : kAxisOrder)
    for (Eigen::Index joint = 0; joint < kJoints; ++joint) io(m.jacobian(row, joint));
  by_rows(io, m.mass);
  in_order(io, m.gravity);
}

template <class Io, class M>
void measurement_fields(Io& io, M& m, std::uint16_t& size, std::uint16_t& id) {
  header(io, m, size, id);
  krl(io, m.krl);
  interface_fields(io, m);
  robot_fields(io, m);
  data_fields(io, m);
}

template <class Io, class C>
void command_fields(Io& io, C& c, std::uint16_t& size, std::uint16_t& id) {
  header(io, c, size, id);
  krl(io, c.krl);
  io(c.flags);
  in_order(io, c.q);
  frame(io, c.X_BT);
  in_order(io, c.tau);
  wrench(io, c.wrench);
  in_order(io, c.stiffness);
  in_order(io, c.damping);
  axes(io, c.cartesian_stiffness);
  axes(io, c.cartesian_damping);
}

std::optional<Misread> misread(std::uint16_t size, std::uint16_t id, std::size_t wanted_size, std::uint16_t wanted_id) {
  if (size != wanted_size) return Misread::kPacketSize;
  if (id != wanted_id) return Misread::kId;
  return std::nullopt;
}

}  // namespace

std::string_view name_of(State state) {
  return state == State::kOff ? "OFF" : state == State::kMonitor ? "MON" : "CMD";
}

std::string_view name_of(Quality quality) {
  constexpr std::array<std::string_view, 4> kNames = {"unacceptable", "bad", "ok", "perfect"};
  return kNames[static_cast<std::size_t>(quality)];
}

std::string_view name_of(Control control) {
  constexpr std::array<std::string_view, 4> kNames = {"other", "position", "Cartesian impedance", "joint impedance"};
  return kNames[static_cast<std::size_t>(control)];
}

void encode(const Measurement& measurement, std::span<std::byte, kMeasurementSize> bytes) {
  Writer writer(bytes);
  std::uint16_t size = kMeasurementSize, id = kMeasurementId;
  measurement_fields(writer, measurement, size, id);
}

void encode(const Command& command, std::span<std::byte, kCommandSize> bytes) {
  Writer writer(bytes);
  std::uint16_t size = kCommandSize, id = kCommandId;
  command_fields(writer, command, size, id);
}

std::expected<Measurement, Misread> decode_measurement(std::span<const std::byte> bytes) {
  if (bytes.size() != kMeasurementSize) return std::unexpected(Misread::kSize);
  Reader reader(bytes);
  Measurement m;
  std::uint16_t size = 0, id = 0;
  measurement_fields(reader, m, size, id);
  if (const auto wrong = misread(size, id, kMeasurementSize, kMeasurementId)) return std::unexpected(*wrong);
  const bool known =
      m.state <= State::kCommand && m.quality <= Quality::kPerfect && m.control <= Control::kJointImpedance;
  if (!known) return std::unexpected(Misread::kValue);
  return m;
}

std::expected<Command, Misread> decode_command(std::span<const std::byte> bytes) {
  if (bytes.size() != kCommandSize) return std::unexpected(Misread::kSize);
  Reader reader(bytes);
  Command c;
  std::uint16_t size = 0, id = 0;
  command_fields(reader, c, size, id);
  if (const auto wrong = misread(size, id, kCommandSize, kCommandId)) return std::unexpected(*wrong);
  return c;
}

}  // namespace takt::hw::fri
