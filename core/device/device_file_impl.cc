#include "core/device/device_file_impl.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"

namespace takt::device {

using Json = nlohmann::ordered_json;

Result<DeviceFile> DeviceFile::open(const fs::path& folder, const std::string& kind) {
  auto json = read_json(folder / kFileName);
  if (!json) return std::unexpected(std::move(json.error()));
  return DeviceFile(folder, std::move(*json), kind);
}

DeviceFile::DeviceFile(fs::path folder, Json json, const std::string& kind)
    : folder_(std::move(folder)),
      json_(std::make_unique<Json>(std::move(json))),
      kind_(kind),
      diagnostics_(std::make_unique<Diagnostics>()) {}

DeviceFile::DeviceFile(DeviceFile&&) noexcept = default;
DeviceFile& DeviceFile::operator=(DeviceFile&&) noexcept = default;
DeviceFile::~DeviceFile() = default;

std::string DeviceFile::link(ObjectReader& reader, const char* key, std::optional<std::string> fallback) {
  std::string name = reader.text(key, std::move(fallback));
  check_link(name, reader.at(key));
  return name;
}

fs::path DeviceFile::load_urdf(const std::string& name, const std::string& pointer) {
  if (name.empty()) return {};
  const auto path = resolve_below(folder_, name, pointer);
  if (!path) {
    diagnostics_->append(path.error());
    return {};
  }
  auto robot = kinematics::RobotModel::load(*path);
  if (!robot) {
    diagnostics_->append(robot.error(), {}, path->string());
    return *path;
  }
  robot_ = std::make_shared<const kinematics::RobotModel>(std::move(*robot));
  return *path;
}

void DeviceFile::check_link(const std::string& name, const std::string& pointer) {
  if (robot_ == nullptr || name.empty() || robot_->link(name) != nullptr) return;
  std::vector<std::string> names;
  for (const auto& one : robot_->links) names.push_back(one.name);
  diagnostics_->error(Code::kUnknownName, pointer, fmt::format("the URDF has no link '{}'", name),
                      nearest_choice(name, names));
}

Nanoseconds read_cycle(ObjectReader& reader) {
  return static_cast<Nanoseconds>(std::llround(reader.number("cycle_ms", 1.0, kPositive) * kMillisecond));
}

}  // namespace takt::device
