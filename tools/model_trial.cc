#include "tools/model_trial.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cell/build/device_kind_registry.h"
#include "cell/run/session.h"
#include "core/base/json.h"
#include "core/base/json_lines.h"
#include "core/base/output_file.h"
#include "core/kinematics/robot_model.h"
#include "tools/model_picture.h"

namespace takt::tools {

namespace fs = std::filesystem;

Diagnostics check_model(const fs::path& folder) {
  const auto kind = device::read_device_kind(folder);
  std::error_code error;
  const auto name = fs::canonical(folder, error).filename().string();
  if (kind && *kind == "object") {  // no device: a body to stand in the room
    const auto body = kinematics::RobotModel::load(folder / (name + ".urdf"));
    return body ? check_build(*body, nullptr) : body.error();
  }
  const auto read = cell::read_model(folder);
  if (!read) return read.error();
  const device::ModelDescription& model = *read->model;
  if (model.robot == nullptr) return {};
  Diagnostics built = check_build(*model.robot, dynamic_cast<const device::ArmDescription*>(&model));
  built.set_file((folder / "device.json").string());
  return built;
}

namespace {

using Json = nlohmann::ordered_json;

/// Each joint that turns goes a little to its roomier side, and home again.
Json joint_wave(const device::ArmDescription& arm) {
  constexpr double kMostSwing = 20.0, kShare = 0.4, kDegree = 180.0 / M_PI;
  std::vector<double> home;
  Json steps = Json::array();
  for (std::size_t i = 0; i < arm.joint_names.size(); ++i) {
    const bool slides = arm.robot->joint(arm.joint_names[i])->type == kinematics::JointType::kPrismatic;
    home.push_back(arm.home[static_cast<Eigen::Index>(i)] * (slides ? 1.0 : kDegree));
  }
  for (std::size_t i = 0; i < home.size(); ++i) {
    const kinematics::Joint& joint = *arm.robot->joint(arm.joint_names[i]);
    if (joint.type == kinematics::JointType::kPrismatic) continue;
    const double up = joint.upper * kDegree - home[i], down = home[i] - joint.lower * kDegree;
    std::vector<double> goal = home;
    goal[i] += std::min(kMostSwing, kShare * std::max(up, down)) * (up >= down ? 1.0 : -1.0);
    steps.push_back(
        {{"do", "ptp"}, {"name", "move " + arm.joint_names[i]}, {"to", {{"joints_deg", goal}}}, {"speed", 0.5}});
    steps.push_back({{"do", "ptp"}, {"name", "home"}, {"to", "home"}, {"speed", 0.5}});
  }
  return steps;
}

/// A wave of the joints, as a scenario in the folder of the model. @return it is one that can be run
bool write_joint_wave(const fs::path& folder, const fs::path& wave, const device::ModelLibrary& library) {
  const auto arm = device::read_arm(folder);
  const auto text = read_file(wave, std::size_t{1} << 20);
  if (!arm || !text) return false;
  const std::string name = folder.filename().string();
  Json scenario = Json::parse(*text, nullptr, false);
  if (scenario.is_discarded()) return false;
  scenario.erase("$schema");
  scenario["title"] = fmt::format("Wave: {} moves its joints", name);
  scenario["description"] = "Each joint moves a little and goes home again.";
  scenario["time_limit_s"] = 120;
  scenario["devices"]["arm"]["model"] = name;
  // Nothing is near: what was made for another pedestal, or has legs, hangs in the air.
  scenario.erase("objects");
  scenario["devices"]["arm"]["at"]["position_m"] = {0.0, 0.0, 1.2};
  scenario["program"]["steps"] = joint_wave(**arm);
  for (Json& one : scenario["expectations"])
    if (one.value("kind", "") == "duration") one["below_s"] = 100;
  const fs::path file = folder / "wave.json";
  if (write_file(file, in_lines(scenario) + "\n", "--out").has_errors()) return false;
  if (cell::Session::open(file, library, {})) return true;
  std::error_code error;
  fs::remove(file, error);
  return false;
}

}  // namespace

void try_wave(const fs::path& folder, const device::ModelLibrary& library, const fs::path& root,
              std::vector<ImportNote>& notes) {
  const fs::path wave = root / "scenarios/wave.json";
  std::error_code error;
  if (!fs::is_regular_file(wave, error)) return;
  fs::remove(folder / "wave.json", error);  // of another home
  cell::OpenOptions options;
  options.overrides.push_back({.pointer = "/devices/arm/model", .value = folder.filename().string()});
  const auto session = cell::Session::open(wave, library, options);
  if (session) return;
  const auto& errors = session.error().list();
  const bool moves = write_joint_wave(folder, wave, library);
  const auto count = std::ranges::count(errors, Severity::kError, &Diagnostic::severity);
  for (const Diagnostic& one : errors) {
    if (one.severity != Severity::kError) continue;
    const std::string more = moves && count > 1 ? fmt::format(", here and {} times more", count - 1) : std::string();
    notes.push_back({"wave " + one.pointer, one.message,
                     fmt::format("WARNING: scenarios/wave.json does not pass with what was guessed{}{}", more,
                                 one.hint.empty() ? std::string() : ": " + one.hint)});
    if (moves) break;
  }
  if (moves)
    notes.push_back({"wave", "wave.json in the folder moves the joints one after the other",
                     "that is what can be done from home, as with a finger of a hand"});
}

}  // namespace takt::tools
