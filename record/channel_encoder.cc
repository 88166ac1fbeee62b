#include "record/channel_encoder.h"

#include <nlohmann/json.hpp>

namespace takt::record {

namespace {
ChannelPlan plan_of(std::string topic, Schema schema) {
  ChannelPlan plan;
  plan.topic = std::move(topic);
  plan.schema = std::move(schema);
  return plan;
}
}  // namespace

std::string text_list(const std::vector<std::string>& texts) {
  return nlohmann::json(texts).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

ChannelPlan plan_joint_states(std::string topic, std::vector<std::string> joints, JointFields fields) {
  const std::size_t n = joints.size();
  // The row goes quantity by quantity, the message joint by joint; field numbers of foxglove.JointState.
  std::vector<int> numbers;
  if (fields.position) numbers.push_back(2);
  if (fields.velocity) numbers.push_back(3);
  if (fields.effort) numbers.push_back(5);
  std::vector<std::uint32_t> order;
  for (std::size_t joint = 0; joint < n; ++joint) {
    for (std::size_t part = 0; part < numbers.size(); ++part) {
      order.push_back(static_cast<std::uint32_t>(part * n + joint));
    }
  }
  ChannelPlan plan = plan_of(std::move(topic), known_schema(kJointStatesSchema));
  plan.row_size = order.size();
  plan.joint_fields = fields;
  plan.joint_count = n;
  plan.rows = RowEncoder(
      [joints = std::move(joints), numbers](std::size_t stamp_size) {
        WirePattern message(stamp_size);
        message.add_stamp(1);
        for (const std::string& name : joints) {
          WirePattern joint(stamp_size);
          joint.add_text(1, name);
          for (const int field : numbers) joint.add_double(field);
          message.add_message(2, joint);
        }
        return message;
      },
      std::move(order));
  return plan;
}

ChannelPlan plan_transforms(std::string topic, std::vector<std::pair<std::string, std::string>> frames) {
  ChannelPlan plan = plan_of(std::move(topic), known_schema(kFrameTransformsSchema));
  plan.row_size = 7 * frames.size();
  plan.last_rotations.assign(frames.size(), Eigen::Quaterniond::Identity());
  // w is first in a row and last in the message.
  std::vector<std::uint32_t> order;
  for (std::uint32_t start = 0; start < plan.row_size; start += 7) {
    for (const std::uint32_t at : {0u, 1u, 2u, 4u, 5u, 6u, 3u}) order.push_back(start + at);
  }
  plan.rows = RowEncoder(
      [frames = std::move(frames)](std::size_t stamp_size) {
        WirePattern message(stamp_size);
        for (const auto& [parent, child] : frames) {
          WirePattern translation(stamp_size), rotation(stamp_size), transform(stamp_size);
          for (const int field : {1, 2, 3}) translation.add_double(field);
          for (const int field : {1, 2, 3, 4}) rotation.add_double(field);
          transform.add_stamp(1);
          transform.add_text(2, parent);
          transform.add_text(3, child);
          transform.add_message(4, translation);
          transform.add_message(5, rotation);
          message.add_message(1, transform);
        }
        return message;
      },
      std::move(order));
  return plan;
}

ChannelPlan plan_wrench(std::string topic, std::string frame) {
  ChannelPlan plan = plan_of(std::move(topic), known_schema(kWrenchSchema));
  plan.row_size = 6;
  plan.rows = RowEncoder(
      [frame = std::move(frame)](std::size_t stamp_size) {
        WirePattern message(stamp_size), part(stamp_size);
        for (const int field : {1, 2, 3}) part.add_double(field);
        message.add_stamp(1);
        message.add_text(2, frame);
        message.add_message(3, part);
        message.add_message(4, part);
        return message;
      },
      {});
  return plan;
}

ChannelPlan plan_samples(std::string topic, std::vector<std::string> columns, std::vector<std::string> units) {
  units.resize(columns.size());
  ChannelPlan plan = plan_of(topic, samples_schema(topic, columns));
  plan.metadata = {{"columns", text_list(columns)}, {"units", text_list(units)}};
  plan.row_size = columns.size();
  plan.rows = RowEncoder(
      [count = columns.size()](std::size_t stamp_size) {
        WirePattern message(stamp_size);
        message.add_stamp(1);
        for (std::size_t i = 0; i < count; ++i) message.add_double(static_cast<int>(i) + 2);
        return message;
      },
      {});
  return plan;
}

ChannelPlan plan_state(std::string topic, std::vector<std::string> names) {
  ChannelPlan plan = plan_of(std::move(topic), known_schema(kSimStateSchema));
  plan.metadata = {{"columns", text_list(names)}};
  plan.row_size = names.size();
  plan.rows = RowEncoder(
      [count = names.size()](std::size_t stamp_size) {
        WirePattern message(stamp_size);
        message.add_stamp(1);
        message.add_packed_doubles(2, count);
        return message;
      },
      {});
  return plan;
}

ChannelPlan plan_texts(std::string topic, RowKind kind) {
  const std::string_view name = kind == RowKind::kDigest  ? kDigestSchema
                                : kind == RowKind::kEvent ? kEventSchema
                                                          : kLogSchema;
  ChannelPlan plan = plan_of(std::move(topic), known_schema(name));
  plan.kind = kind;
  return plan;
}

ChannelPlan plan_constant(std::string topic, std::string_view schema, std::string bytes) {
  ChannelPlan plan = plan_of(std::move(topic), known_schema(schema));
  plan.kind = RowKind::kConstant;
  plan.constant = std::move(bytes);
  return plan;
}

}  // namespace takt::record
