// Each field of the two datagrams: where it lies, in which unit, order and sign.
#include "hw/fri/protocol/packet.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace takt::hw::fri {
namespace {

using MeasurementBytes = std::array<std::byte, kMeasurementSize>;
using CommandBytes = std::array<std::byte, kCommandSize>;

/// Numbers as a controller would put them there, without the code under test.
template <class Bytes>
void put_u16(Bytes& bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = std::byte(value & 0xff);
  bytes[at + 1] = std::byte(value >> 8);
}
template <class Bytes>
void put_u32(Bytes& bytes, std::size_t at, std::uint32_t value) {
  put_u16(bytes, at, static_cast<std::uint16_t>(value & 0xffff));
  put_u16(bytes, at + 2, static_cast<std::uint16_t>(value >> 16));
}
template <class Bytes>
void put_f32(Bytes& bytes, std::size_t at, float value) {
  put_u32(bytes, at, std::bit_cast<std::uint32_t>(value));
}

MeasurementBytes empty_measurement() {
  MeasurementBytes bytes{};
  put_u16(bytes, 4, 916);
  put_u16(bytes, 6, 0x2006);
  return bytes;
}
CommandBytes empty_command() {
  CommandBytes bytes{};
  put_u16(bytes, 4, 376);
  put_u16(bytes, 6, 0x1005);
  return bytes;
}

/// A field of binary32 numbers: the n-th on the wire is read by `get` with n.
struct RealField {
  const char* name;
  std::size_t offset;
  int count;
  std::function<double(const Measurement&, int)> get;
};

double frame_element(const Eigen::Isometry3d& X, int i) { return X.matrix()(i / 4, i % 4); }
/// Fx Fy Fz Tz Ty Tx.
double wrench_element(const net::Wrench& wrench, int i) { return i < 3 ? wrench.force[i] : wrench.torque[5 - i]; }
/// X Y Z RZ RY RX.
int row_on_wire(int i) { return i < 3 ? i : 8 - i; }

const RealField kMeasurementFields[] = {
    {"krl.realData", 8, 16, [](const auto& m, int i) { return m.krl.real[static_cast<std::size_t>(i)]; }},
    {"intf.timestamp", 140, 1, [](const auto& m, int) { return m.timestamp; }},
    {"intf.desiredMsrSampleTime", 148, 1, [](const auto& m, int) { return m.measurement_period; }},
    {"intf.desiredCmdSampleTime", 152, 1, [](const auto& m, int) { return m.command_period; }},
    {"intf.safetyLimits", 156, 1, [](const auto& m, int) { return m.safety_limits; }},
    {"stat.answerRate", 160, 1, [](const auto& m, int) { return m.statistics.answer_rate; }},
    {"stat.latency", 164, 1, [](const auto& m, int) { return m.statistics.latency; }},
    {"stat.jitter", 168, 1, [](const auto& m, int) { return m.statistics.jitter; }},
    {"stat.missRate", 172, 1, [](const auto& m, int) { return m.statistics.miss_rate; }},
    {"robot.temperature", 188, 7, [](const auto& m, int i) { return m.temperature[i]; }},
    {"data.msrJntPos", 216, 7, [](const auto& m, int i) { return m.q[i]; }},
    {"data.msrCartPos", 244, 12, [](const auto& m, int i) { return frame_element(m.X_BT, i); }},
    {"data.cmdJntPos", 292, 7, [](const auto& m, int i) { return m.q_before[i]; }},
    {"data.cmdJntPosFriOffset", 320, 7, [](const auto& m, int i) { return m.q_offset[i]; }},
    {"data.cmdCartPos", 348, 12, [](const auto& m, int i) { return frame_element(m.X_BT_before, i); }},
    {"data.cmdCartPosFriOffset", 396, 12, [](const auto& m, int i) { return frame_element(m.X_offset, i); }},
    {"data.msrJntTrq", 444, 7, [](const auto& m, int i) { return m.tau[i]; }},
    {"data.estExtJntTrq", 472, 7, [](const auto& m, int i) { return m.tau_external[i]; }},
    {"data.estExtTcpFT", 500, 6, [](const auto& m, int i) { return wrench_element(m.wrench_external, i); }},
    {"data.jacobian", 524, 42, [](const auto& m, int i) { return m.jacobian(row_on_wire(i / 7), i % 7); }},
    {"data.massMatrix", 692, 49, [](const auto& m, int i) { return m.mass(i / 7, i % 7); }},
    {"data.gravity", 888, 7, [](const auto& m, int i) { return m.gravity[i]; }},
};

TEST(FriPacket, EachRealOfAMeasurementIsReadFromItsPlaceAndNoOther) {
  for (const RealField& field : kMeasurementFields) {
    for (int i = 0; i < field.count; ++i) {
      MeasurementBytes bytes = empty_measurement();
      put_f32(bytes, field.offset + 4 * static_cast<std::size_t>(i), -1.5f);
      const auto m = decode_measurement(bytes);
      ASSERT_TRUE(m) << field.name;
      for (const RealField& other : kMeasurementFields) {
        for (int j = 0; j < other.count; ++j) {
          const bool same = &other == &field && i == j;
          ASSERT_EQ(other.get(*m, j), same ? -1.5 : 0.0) << field.name << i << " seen in " << other.name << j;
        }
      }
    }
  }
}

TEST(FriPacket, WholeNumbersOfAMeasurement) {
  MeasurementBytes bytes = empty_measurement();
  put_u16(bytes, 0, 65535);
  put_u16(bytes, 2, 258);
  for (std::size_t i = 0; i < 16; ++i) put_u32(bytes, 72 + 4 * i, 0u - static_cast<std::uint32_t>(i));
  put_u16(bytes, 136, 0x8001);
  put_u16(bytes, 144, 2);
  put_u16(bytes, 146, 3);
  put_u32(bytes, 176, 70'000);
  put_u16(bytes, 180, 0x7f);
  put_u16(bytes, 182, 2);
  put_u16(bytes, 184, 4);
  put_u16(bytes, 186, 8);
  const auto m = decode_measurement(bytes);
  ASSERT_TRUE(m);
  EXPECT_EQ(m->sequence, 65535);
  EXPECT_EQ(m->reflected, 258);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(m->krl.integer[static_cast<std::size_t>(i)], -i);
  EXPECT_EQ(m->krl.boolean, 0x8001);
  EXPECT_EQ(m->state, State::kCommand);
  EXPECT_EQ(m->quality, Quality::kPerfect);
  EXPECT_EQ(m->statistics.misses, 70'000u);
  EXPECT_EQ(m->power, kAllDrives);
  EXPECT_EQ(m->control, Control::kCartesianImpedance);
  EXPECT_EQ(m->error, 4);
  EXPECT_EQ(m->warning, 8);
  EXPECT_EQ(name_of(m->state), "CMD");
  EXPECT_EQ(name_of(m->quality), "perfect");
  EXPECT_EQ(name_of(m->control), "Cartesian impedance");
}

struct CommandField {
  const char* name;
  std::size_t offset;
  int count;
  std::function<void(Command&, int, double)> set;
};

const CommandField kCommandFields[] = {
    {"krl.realData", 8, 16, [](auto& c, int i, double v) { c.krl.real[static_cast<std::size_t>(i)] = float(v); }},
    {"jntPos", 144, 7, [](auto& c, int i, double v) { c.q[i] = v; }},
    {"cartPos", 172, 12, [](auto& c, int i, double v) { c.X_BT.matrix()(i / 4, i % 4) = v; }},
    {"addJntTrq", 220, 7, [](auto& c, int i, double v) { c.tau[i] = v; }},
    {"addTcpFT", 248, 6, [](auto& c, int i, double v) { (i < 3 ? c.wrench.force[i] : c.wrench.torque[5 - i]) = v; }},
    {"jntStiffness", 272, 7, [](auto& c, int i, double v) { c.stiffness[i] = v; }},
    {"jntDamping", 300, 7, [](auto& c, int i, double v) { c.damping[i] = v; }},
    {"cartStiffness", 328, 6, [](auto& c, int i, double v) { c.cartesian_stiffness[row_on_wire(i)] = v; }},
    {"cartDamping", 352, 6, [](auto& c, int i, double v) { c.cartesian_damping[row_on_wire(i)] = v; }},
};

TEST(FriPacket, EachRealOfACommandIsWrittenToItsPlaceAndNoOther) {
  Command zero;
  zero.X_BT.matrix().setZero();
  CommandBytes before{};
  encode(zero, before);
  for (const CommandField& field : kCommandFields) {
    for (int i = 0; i < field.count; ++i) {
      Command command = zero;
      field.set(command, i, 0.1);
      CommandBytes bytes{}, expected = before;
      encode(command, bytes);
      put_f32(expected, field.offset + 4 * static_cast<std::size_t>(i), 0.1f);
      ASSERT_EQ(bytes, expected) << field.name << i;
      const auto back = decode_command(bytes);
      ASSERT_TRUE(back);
      CommandBytes again{};
      encode(*back, again);
      ASSERT_EQ(again, bytes) << field.name << i;
    }
  }
}

TEST(FriPacket, WholeNumbersOfACommand) {
  Command command;
  command.sequence = 0x1234;
  command.reflected = 0xabcd;
  command.krl.integer[15] = -2;
  command.krl.boolean = 0x8000;
  command.flags = kCartesianImpedanceFlags;
  command.X_BT.matrix().setZero();
  CommandBytes bytes{}, expected = empty_command();
  encode(command, bytes);
  put_u16(expected, 0, 0x1234);
  put_u16(expected, 2, 0xabcd);
  put_u32(expected, 72 + 4 * 15, 0xffff'fffe);
  put_u16(expected, 136, 0x8000);
  put_u32(expected, 140, 0x3501);
  EXPECT_EQ(bytes, expected);
  EXPECT_EQ(kPositionFlags, 0x0001u);
  EXPECT_EQ(kJointImpedanceFlags, 0x0035u);
}

TEST(FriPacket, AMeasurementSurvivesBothWays) {
  Measurement m;
  m.sequence = 7;
  m.state = State::kMonitor;
  m.X_BT = Eigen::Translation3d(0.25, -0.5, 0.75) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX());
  m.wrench_external.force = {1.0, 2.0, 3.0};
  m.wrench_external.torque = {4.0, 5.0, 6.0};
  MeasurementBytes bytes{}, again{};
  encode(m, bytes);
  const auto back = decode_measurement(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->wrench_external.torque, m.wrench_external.torque);
  EXPECT_TRUE(back->X_BT.isApprox(m.X_BT, 1e-7));
  encode(*back, again);
  EXPECT_EQ(bytes, again);
}

TEST(FriPacket, OnlyItsOwnLengthIsRead) {
  std::vector<std::byte> bytes(2000);
  const MeasurementBytes measurement = empty_measurement();
  const CommandBytes command = empty_command();
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    std::fill(bytes.begin(), bytes.end(), std::byte{0});
    std::copy_n(measurement.begin(), std::min(size, measurement.size()), bytes.begin());
    const auto m = decode_measurement(std::span(bytes).first(size));
    ASSERT_EQ(m.has_value(), size == kMeasurementSize) << size;
    ASSERT_TRUE(m || m.error() == Misread::kSize);
    std::copy_n(command.begin(), std::min(size, command.size()), bytes.begin());
    const auto c = decode_command(std::span(bytes).first(size));
    ASSERT_EQ(c.has_value(), size == kCommandSize) << size;
    ASSERT_TRUE(c || c.error() == Misread::kSize);
  }
}

TEST(FriPacket, AnotherVersionDirectionLengthOrStateIsNamed) {
  const auto misread = [](std::size_t at, std::uint16_t value) {
    MeasurementBytes bytes = empty_measurement();
    put_u16(bytes, at, value);
    const auto m = decode_measurement(bytes);
    return m ? std::nullopt : std::optional(m.error());
  };
  EXPECT_EQ(misread(4, 915), Misread::kPacketSize);
  EXPECT_EQ(misread(6, 0x1005), Misread::kId);
  EXPECT_EQ(misread(144, 3), Misread::kValue);
  EXPECT_EQ(misread(146, 4), Misread::kValue);
  EXPECT_EQ(misread(182, 4), Misread::kValue);
  EXPECT_EQ(misread(184, 0xffff), std::nullopt) << "what it means is the driver's to judge";
  CommandBytes bytes = empty_command();
  put_u16(bytes, 4, 916);
  EXPECT_EQ(decode_command(bytes).error(), Misread::kPacketSize);
  bytes = empty_command();
  put_u16(bytes, 6, 0x2006);
  EXPECT_EQ(decode_command(bytes).error(), Misread::kId);
}

TEST(FriPacket, NumbersThatAreNoneArePassedOn) {
  MeasurementBytes bytes = empty_measurement();
  put_f32(bytes, 216, std::numeric_limits<float>::quiet_NaN());
  put_f32(bytes, 220, std::numeric_limits<float>::infinity());
  const auto m = decode_measurement(bytes);
  ASSERT_TRUE(m);
  EXPECT_TRUE(std::isnan(m->q[0]));
  EXPECT_TRUE(std::isinf(m->q[1]));
}

TEST(FriPacket, StatesHaveTheirNames) {
  EXPECT_EQ(name_of(State::kOff), "OFF");
  EXPECT_EQ(name_of(State::kMonitor), "MON");
  EXPECT_EQ(name_of(State::kCommand), "CMD");
}

}  // namespace
}  // namespace takt::hw::fri
