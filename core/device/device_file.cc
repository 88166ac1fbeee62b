#include "core/device/device_file.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/device/arm_reader.h"
#include "core/device/device_file_impl.h"
#include "core/kinematics/robot_model.h"

namespace takt::device {

namespace {

using Json = nlohmann::ordered_json;

net::Wrench read_wrench(ObjectReader& parent, const char* key, bool required) {
  const Json* json = parent.object(key, required);
  if (json == nullptr) return {};
  ObjectReader reader(*json, parent.at(key), parent.diagnostics());
  const auto channel = [&reader](const char* name) -> Eigen::Vector3d {
    const auto values = reader.numbers(name, 3, {}, kNotNegative);
    return values.size() == 3 ? Eigen::Vector3d(values[0], values[1], values[2]) : Eigen::Vector3d::Zero();
  };
  net::Wrench wrench{.force = channel("force_N"), .torque = channel("torque_Nm")};
  reader.finish();
  return wrench;
}

}  // namespace

Result<std::string> read_device_kind(const fs::path& folder) {
  auto json = read_json(folder / kFileName);
  if (!json) return std::unexpected(std::move(json.error()));
  Diagnostics diagnostics;
  std::string kind = ObjectReader(*json, "", diagnostics).text("kind");
  diagnostics.set_file((folder / kFileName).string());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return kind;
}

Result<std::shared_ptr<const ArmDescription>> read_arm(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "arm");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  ArmDescription arm;
  ArmReader(*file, reader, arm).read();
  return file->finish(reader, std::move(arm));
}

Result<std::shared_ptr<const ForceTorqueDescription>> read_force_torque_sensor(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "force_torque_sensor");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  ForceTorqueDescription sensor;
  sensor.mount_link = file->read_common(reader, sensor);
  sensor.measuring_link = file->link(reader, "measuring");
  sensor.tool_link = file->link(reader, "flange");
  sensor.cycle = read_cycle(reader);
  sensor.sample_age_max = kSampleCyclesMax * sensor.cycle;
  sensor.range = read_wrench(reader, "range", true);
  sensor.noise = read_wrench(reader, "noise_sigma", true);
  sensor.bias = read_wrench(reader, "bias_sigma", false);
  sensor.low_pass_hz = reader.has("low_pass_Hz") ? reader.number("low_pass_Hz", {}, kPositive) : 0.0;
  if (file->robot() != nullptr && !file->diagnostics().has_errors()) {
    sensor.X_MS = pose_between(*file->robot(), sensor.mount_link, sensor.measuring_link);
    sensor.X_MT = pose_between(*file->robot(), sensor.mount_link, sensor.tool_link);
  }
  return file->finish(reader, std::move(sensor));
}

Result<std::shared_ptr<const ToolDescription>> read_tool(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "tool");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  ToolDescription tool;
  tool.mount_link = file->read_common(reader, tool);
  tool.tcp_link = file->link(reader, "tcp");
  if (reader.has("flange")) file->link(reader, "flange");
  tool.tip.ball_radius = reader.has("ball_radius_m") ? reader.number("ball_radius_m", {}, kPositive) : 0.0;
  if (file->robot() != nullptr && !file->diagnostics().has_errors()) {
    tool.X_MT = pose_between(*file->robot(), tool.mount_link, tool.tcp_link);
    tool.tip.compliance_T = compliance_of(*file->robot(), file->plant().springs, tool.tcp_link);
    tool.payload = transform(pose_between(*file->robot(), tool.mount_link, file->robot()->root().name),
                             rigid_payload(*file->robot()));
  }
  return file->finish(reader, std::move(tool));
}

std::vector<std::string> ModelLibrary::names() const {
  std::set<std::string> names;
  for (const fs::path& path : paths_) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(path, ignored))
      if (fs::is_regular_file(entry.path() / kFileName, ignored)) names.insert(entry.path().filename().string());
  }
  return {names.begin(), names.end()};
}

ModelLibrary ModelLibrary::beside(const fs::path& file) const {
  if (file.empty()) return *this;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::vector<fs::path> paths{folder, folder / "models"};
  paths.insert(paths.end(), paths_.begin(), paths_.end());
  return ModelLibrary(std::move(paths));
}

Result<fs::path> ModelLibrary::find(std::string_view name, const std::string& pointer) const {
  const bool one_segment = !name.empty() && name.find_first_of("/\\") == name.npos && name != "." && name != "..";
  for (const fs::path& path : paths_) {
    std::error_code ignored;
    if (one_segment && fs::is_regular_file(path / name / kFileName, ignored)) return path / name;
  }
  const std::vector<std::string> known = names();
  std::vector<std::string> searched;
  for (const fs::path& path : paths_) searched.push_back(path.string());
  return failure(Code::kUnknownName, pointer, fmt::format("unknown model '{}'", name),
                 fmt::format("{}; searched: {}; --models DIR searches one more",
                             nearest_choice(name, known, known.size()), fmt::join(searched, ", ")));
}

}  // namespace takt::device
