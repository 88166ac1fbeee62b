#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "record/mcap_format.h"
#include "record/recorder.h"
#include "record/schemas.h"
#include "record/wire_pattern.h"

namespace takt::record {

/// What the cycle hands over for one message.
enum class RowKind : std::uint8_t { kNumbers, kDigest, kEvent, kLog, kConstant };

/// A channel as the recorder knows it: its place in the file and how its rows become messages.
struct ChannelPlan {
  std::string topic;
  Schema schema;
  mcap::Map metadata;
  RowKind kind = RowKind::kNumbers;
  std::size_t row_size = 0;
  JointFields joint_fields;
  std::size_t joint_count = 0;
  std::vector<Eigen::Quaterniond> last_rotations;  ///< of transforms: the signs go on from them
  RowEncoder rows;
  std::string constant;  ///< the only message
};

[[nodiscard]] ChannelPlan plan_joint_states(std::string topic, std::vector<std::string> joints, JointFields fields);
[[nodiscard]] ChannelPlan plan_transforms(std::string topic, std::vector<std::pair<std::string, std::string>> frames);
[[nodiscard]] ChannelPlan plan_wrench(std::string topic, std::string frame);
[[nodiscard]] ChannelPlan plan_samples(std::string topic, std::vector<std::string> columns,
                                       std::vector<std::string> units);
[[nodiscard]] ChannelPlan plan_state(std::string topic, std::vector<std::string> names);
/// Digests, events and log lines.
[[nodiscard]] ChannelPlan plan_texts(std::string topic, RowKind kind);

/// One message, which is there from the begin on.
[[nodiscard]] ChannelPlan plan_constant(std::string topic, std::string_view schema, std::string bytes);

/// JSON array of texts, for the channel's metadata.
[[nodiscard]] std::string text_list(const std::vector<std::string>& texts);

}  // namespace takt::record
