#include "record/decode.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

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

RowDecoder::RowDecoder(const ChannelInfo& channel, std::optional<std::vector<std::size_t>> columns, std::size_t rows)
    : channel_(channel), wanted_(std::move(columns)), rows_(rows) {}

bool RowDecoder::parse(const MessageView& message) {
  row_.clear();
  const bool first = !has_header_;
  if (channel_.schema == kJointStatesSchema) {
    foxglove::JointStates joints;
    if (!parse_message(message, joints)) return false;
    joint_row(joints, first, all_, row_);
  } else if (channel_.schema == kFrameTransformsSchema) {
    foxglove::FrameTransforms transforms;
    if (!parse_message(message, transforms)) return false;
    transform_row(transforms, first, all_, row_);
  } else if (channel_.schema == kWrenchSchema) {
    Wrench wrench;
    if (!parse_message(message, wrench)) return false;
    const auto& f = wrench.force();
    const auto& t = wrench.torque();
    row_ = {f.x(), f.y(), f.z(), t.x(), t.y(), t.z()};
    if (first) {
      all_.columns = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
      all_.units = {"N", "N", "N", "Nm", "Nm", "Nm"};
    }
  } else if (channel_.schema == kSimStateSchema) {
    SimState state;
    if (!parse_message(message, state)) return false;
    row_.assign(state.values().begin(), state.values().end());
    if (first) all_.columns = list_of(channel_, "columns");
  } else {
    if (first) {
      all_.columns = list_of(channel_, "columns");
      all_.units = list_of(channel_, "units");
    }
    row_.assign(all_.columns.size(), kNull);
    if (!sample_row(message, row_)) return false;
  }
  return true;
}

void RowDecoder::begin(Table& table) {
  has_header_ = true;
  all_.columns.resize(std::min(all_.columns.size(), mcap::ReadLimits::kColumns));
  all_.units.resize(all_.columns.size());
  if (!wanted_) {
    wanted_.emplace(all_.columns.size());
    std::iota(wanted_->begin(), wanted_->end(), std::size_t{0});
  }
  std::erase_if(*wanted_, [this](std::size_t i) { return i >= all_.columns.size(); });
  for (const std::size_t i : *wanted_) {
    table.columns.push_back(all_.columns[i]);
    table.units.push_back(all_.units[i]);
  }
  const std::size_t count = wanted_->size();
  table.values.resize(count);
  const std::size_t most = mcap::ReadLimits::kTableValues / (count + 1) + 1;
  table.time.reserve(std::min(rows_, most));
  for (std::vector<double>& column : table.values) column.reserve(std::min(rows_, most));
}

bool RowDecoder::append(const MessageView& message, Table& table) {
  if (!parse(message)) {
    if (!has_header_) all_ = {};
    return false;
  }
  if (!has_header_) begin(table);
  // Later messages of another shape: what is missing is null.
  row_.resize(all_.columns.size(), kNull);
  table.time.push_back(message.time);
  for (std::size_t i = 0; i < wanted_->size(); ++i) table.values[i].push_back(row_[(*wanted_)[i]]);
  return true;
}

}  // namespace takt::record
