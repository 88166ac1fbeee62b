#include "record/decode.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "foxglove/FrameTransforms.pb.h"
#include "foxglove/JointStates.pb.h"
#include "record/mcap_reader.h"
#include "record/parse_message.h"
#include "record/schemas.h"
#include "takt/SimState.pb.h"
#include "takt/Wrench.pb.h"

namespace takt::record {

namespace {

constexpr double kNull = std::numeric_limits<double>::quiet_NaN();

bool is_samples(const ChannelInfo& channel) {
  return channel.schema.starts_with(kSamplesPackage) && channel.metadata.contains("columns");
}

std::vector<std::string> list_of(const ChannelInfo& channel, const std::string& key) {
  const auto found = channel.metadata.find(key);
  if (found == channel.metadata.end()) return {};
  const auto json = parse_json(found->second);
  std::vector<std::string> list;
  if (!json || !json->is_array()) return list;
  for (const auto& item : *json) list.push_back(item.is_string() ? item.get<std::string>() : "");
  return list;
}

struct Quantity {
  const char* name;
  const char* unit;
  bool (foxglove::JointState::*has)() const;
  double (foxglove::JointState::*get)() const;
};
constexpr Quantity kQuantities[] = {
    {"position", "rad", &foxglove::JointState::has_position, &foxglove::JointState::position},
    {"velocity", "rad/s", &foxglove::JointState::has_velocity, &foxglove::JointState::velocity},
    {"effort", "Nm", &foxglove::JointState::has_effort, &foxglove::JointState::effort},
};

/// Joint states: quantity by quantity, so that curves of one kind stand together.
void joint_row(const foxglove::JointStates& message, bool name_columns, Table& table, std::vector<double>& row) {
  for (const Quantity& quantity : kQuantities) {
    for (const foxglove::JointState& joint : message.joints()) {
      if (!(joint.*quantity.has)()) continue;
      row.push_back((joint.*quantity.get)());
      if (!name_columns) continue;
      table.columns.push_back(fmt::format("{}.{}", joint.name(), quantity.name));
      table.units.emplace_back(quantity.unit);
    }
  }
}

void transform_row(const foxglove::FrameTransforms& message, bool name_columns, Table& table,
                   std::vector<double>& row) {
  for (const foxglove::FrameTransform& transform : message.transforms()) {
    const auto& p = transform.translation();
    const auto& q = transform.rotation();
    row.insert(row.end(), {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
    if (!name_columns) continue;
    for (const char* part : {"x", "y", "z", "qw", "qx", "qy", "qz"}) {
      table.columns.push_back(fmt::format("{}.{}", transform.child_frame_id(), part));
      table.units.emplace_back(part[0] == 'q' ? "" : "m");
    }
  }
}

/// Samples: field number minus 2 is the column; other fields are skipped.
bool sample_row(const MessageView& view, std::vector<double>& row) {
  google::protobuf::io::CodedInputStream in(reinterpret_cast<const std::uint8_t*>(view.data.data()),
                                            static_cast<int>(view.data.size()));
  while (const std::uint32_t tag = in.ReadTag()) {
    const std::size_t column = (tag >> 3) - 2;
    std::uint64_t bits = 0;
    std::uint32_t size = 0;
    switch (tag & 7) {
      case 0:
        if (!in.ReadVarint64(&bits)) return false;
        break;
      case 1:
        if (!in.ReadLittleEndian64(&bits)) return false;
        if (column < row.size()) row[column] = std::bit_cast<double>(bits);
        break;
      case 2:
        if (!in.ReadVarint32(&size) || !in.Skip(static_cast<int>(size))) return false;
        break;
      default:
        return false;
    }
  }
  return in.ConsumedEntireMessage();
}

}  // namespace

bool has_columns(const ChannelInfo& channel) {
  if (channel.encoding != "protobuf") return false;
  return channel.schema == kJointStatesSchema || channel.schema == kFrameTransformsSchema ||
         channel.schema == kWrenchSchema || channel.schema == kSimStateSchema || is_samples(channel);
}

RowDecoder::RowDecoder(const ChannelInfo& channel, std::size_t rows) : channel_(channel), rows_(rows) {}

bool RowDecoder::parse(const MessageView& message, Table& table) {
  row_.clear();
  const bool first = !has_header_;
  if (channel_.schema == kJointStatesSchema) {
    foxglove::JointStates joints;
    if (!parse_message(message, joints)) return false;
    joint_row(joints, first, table, row_);
  } else if (channel_.schema == kFrameTransformsSchema) {
    foxglove::FrameTransforms transforms;
    if (!parse_message(message, transforms)) return false;
    transform_row(transforms, first, table, row_);
  } else if (channel_.schema == kWrenchSchema) {
    Wrench wrench;
    if (!parse_message(message, wrench)) return false;
    const auto& f = wrench.force();
    const auto& t = wrench.torque();
    row_ = {f.x(), f.y(), f.z(), t.x(), t.y(), t.z()};
    if (first) {
      table.columns = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
      table.units = {"N", "N", "N", "Nm", "Nm", "Nm"};
    }
  } else if (channel_.schema == kSimStateSchema) {
    SimState state;
    if (!parse_message(message, state)) return false;
    row_.assign(state.values().begin(), state.values().end());
    if (first) table.columns = list_of(channel_, "columns");
  } else {
    if (first) {
      table.columns = list_of(channel_, "columns");
      table.units = list_of(channel_, "units");
    }
    row_.assign(table.columns.size(), kNull);
    if (!sample_row(message, row_)) return false;
  }
  return true;
}

bool RowDecoder::append(const MessageView& message, Table& table) {
  if (!parse(message, table)) {
    if (!has_header_) table.columns.clear(), table.units.clear();
    return false;
  }
  if (!has_header_) {
    has_header_ = true;
    table.units.resize(table.columns.size());
    table.values.resize(table.columns.size());
    const std::size_t most = mcap::ReadLimits::kTableValues / std::max<std::size_t>(1, table.columns.size());
    for (std::vector<double>& column : table.values) column.reserve(std::min(rows_, most + 1));
  }
  // Later messages of another shape: what is missing is null.
  row_.resize(table.columns.size(), kNull);
  table.time.push_back(message.time);
  for (std::size_t i = 0; i < row_.size(); ++i) table.values[i].push_back(row_[i]);
  return true;
}

}  // namespace takt::record
