#include "tools/model_trial.h"

#include <fmt/format.h>

#include "cell/build/device_kind_registry.h"
#include "cell/run/session.h"
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

void try_wave(const fs::path& folder, const device::ModelLibrary& library, const fs::path& root,
              std::vector<ImportNote>& notes) {
  const fs::path wave = root / "scenarios/wave.json";
  std::error_code error;
  if (!fs::is_regular_file(wave, error)) return;
  cell::OpenOptions options;
  options.overrides.push_back({.pointer = "/devices/arm/model", .value = folder.filename().string()});
  const auto session = cell::Session::open(wave, library, options);
  if (session) return;
  for (const Diagnostic& one : session.error().list()) {
    if (one.severity != Severity::kError) continue;
    notes.push_back({"wave " + one.pointer, one.message,
                     "WARNING: scenarios/wave.json does not pass with what was guessed" +
                         (one.hint.empty() ? std::string() : ": " + one.hint)});
  }
}

}  // namespace takt::tools
