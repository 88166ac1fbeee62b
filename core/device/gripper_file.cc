#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/device_file.h"
#include "core/device/device_file_impl.h"

namespace takt::device {

namespace {

/// Two numbers, the first not above the second.
std::pair<double, double> read_interval(ObjectReader& reader, const char* key) {
  const auto ends = reader.numbers(key, 2, {}, kNotNegative);
  if (ends.size() != 2) return {0.0, 0.0};
  if (ends[0] > ends[1]) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at(key), fmt::format("from {} to {}", ends[0], ends[1]),
                               "Write [smallest, largest]");
  }
  return {ends[0], ends[1]};
}

/// The joints that the drive moves together: prismatic, from zero, all of one length.
void read_fingers(DeviceFile& file, ObjectReader& reader, GripperDescription& gripper) {
  gripper.fingers = reader.texts("fingers");
  if (gripper.fingers.size() != 2) {
    reader.diagnostics().error(Code::kWrongSize, reader.at("fingers"), fmt::format("{} joints", gripper.fingers.size()),
                               "Give the two joints of a parallel gripper");
  }
  if (file.robot() == nullptr) return;
  std::vector<std::string> joints;
  for (const auto& joint : file.robot()->joints) joints.push_back(joint.name);
  for (std::size_t i = 0; i < gripper.fingers.size(); ++i) {
    const std::string pointer = reader.at("fingers") + pointer_segment(i);
    const auto* joint = file.robot()->joint(gripper.fingers[i]);
    if (joint == nullptr) {
      reader.diagnostics().error(Code::kUnknownName, pointer,
                                 fmt::format("the URDF has no joint '{}'", gripper.fingers[i]),
                                 nearest_choice(gripper.fingers[i], joints));
    } else if (joint->type != kinematics::JointType::kPrismatic || joint->lower != 0.0) {
      reader.diagnostics().error(Code::kInvalidValue, pointer, fmt::format("joint '{}' is not a finger", joint->name),
                                 "Make it prismatic, zero where the gripper is closed, opening with positive values");
    } else if (gripper.stroke > 0.0 && joint->upper != 0.5 * gripper.stroke) {
      reader.diagnostics().error(Code::kInvalidValue, pointer,
                                 fmt::format("joint '{}' moves {} m", joint->name, joint->upper),
                                 "Give all fingers the same travel");
    } else {
      gripper.stroke = 2.0 * joint->upper;
    }
  }
}

}  // namespace

Result<std::shared_ptr<const GripperDescription>> read_gripper(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "gripper");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  GripperDescription gripper;
  gripper.mount_link = file->read_common(reader, gripper);
  gripper.tcp_link = file->link(reader, "tcp");
  read_fingers(*file, reader, gripper);
  std::tie(gripper.speed_min, gripper.speed_max) = read_interval(reader, "speed_m_s");
  std::tie(gripper.force_min, gripper.force_max) = read_interval(reader, "force_N");
  gripper.acceleration = reader.number("acceleration_m_s2", {}, kPositive);
  gripper.width_resolution = reader.number("width_resolution_m", 0.0, kNotNegative);
  gripper.finger_inertia = reader.number("finger_inertia_kg", 0.0, kNotNegative);
  gripper.pad_friction = reader.number("pad_friction", {}, kPositive);
  gripper.cycle = read_cycle(reader);
  gripper.sample_age_max = kSampleCyclesMax * gripper.cycle;
  if (file->robot() != nullptr && !file->diagnostics().has_errors()) {
    gripper.X_MT = pose_between(*file->robot(), gripper.mount_link, gripper.tcp_link);
    gripper.payload = transform(pose_between(*file->robot(), gripper.mount_link, file->robot()->root().name),
                                rigid_payload(*file->robot()));
  }
  return file->finish(reader, std::move(gripper));
}

}  // namespace takt::device
