#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/device_file_impl.h"
#include "core/device/screwdriver.h"

namespace takt::device {

namespace {

/// [smallest, largest], both above zero.
std::pair<double, double> read_span(ObjectReader& reader, const char* key) {
  const auto ends = reader.numbers(key, 2, {}, kPositive);
  if (ends.size() != 2) return {0.0, 0.0};
  if (ends[0] > ends[1]) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at(key), fmt::format("from {} to {}", ends[0], ends[1]),
                               "Write [smallest, largest]");
  }
  return {ends[0], ends[1]};
}

std::string read_spindle(DeviceFile& file, ObjectReader& reader) {
  const std::string name = reader.text("spindle");
  if (file.robot() == nullptr) return name;
  const kinematics::Joint* joint = file.robot()->joint(name);
  if (joint != nullptr && joint->type == kinematics::JointType::kContinuous) return name;
  std::vector<std::string> names;
  for (const auto& one : file.robot()->joints) {
    if (one.type == kinematics::JointType::kContinuous) names.push_back(one.name);
  }
  reader.diagnostics().error(Code::kUnknownName, reader.at("spindle"),
                             fmt::format("the URDF has no joint '{}' that turns without end", name),
                             nearest_choice(name, names));
  return name;
}

}  // namespace

Result<std::shared_ptr<const ScrewdriverDescription>> read_screwdriver(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "screwdriver");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  ScrewdriverDescription driver;
  driver.mount_link = file->read_common(reader, driver);
  driver.tcp_link = file->link(reader, "tcp");
  driver.spindle = read_spindle(*file, reader);
  driver.bit = file->link(reader, "bit");
  std::tie(driver.speed_min, driver.speed_max) = read_span(reader, "speed_rad_s");
  std::tie(driver.torque_min, driver.torque_max) = read_span(reader, "torque_Nm");
  driver.acceleration = reader.number("acceleration_rad_s2", {}, kPositive);
  driver.spindle_inertia = reader.number("spindle_inertia_kg_m2", {}, kPositive);
  driver.holding_force = reader.number("holding_force_N", 0.0, kNotNegative);
  driver.torque_noise = reader.number("torque_noise_Nm", 0.0, kNotNegative);
  driver.torque_resolution = reader.number("torque_resolution_Nm", 0.0, kNotNegative);
  driver.angle_resolution = reader.number("angle_resolution_rad", 0.0, kNotNegative);
  driver.cycle = read_cycle(reader);
  driver.sample_age_max = kSampleCyclesMax * driver.cycle;
  if (file->robot() != nullptr && !file->diagnostics().has_errors()) {
    driver.X_MT = pose_between(*file->robot(), driver.mount_link, driver.tcp_link);
    driver.payload = transform(pose_between(*file->robot(), driver.mount_link, file->robot()->root().name),
                               rigid_payload(*file->robot()));
  }
  return file->finish(reader, std::move(driver));
}

}  // namespace takt::device
