#pragma once

#include <filesystem>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/device_file.h"
#include "tools/import/draft.h"

namespace takt::tools {

/// What validate asks of a model folder: its files are right, and the simulator builds it. Realtime: setup.
[[nodiscard]] Diagnostics check_model(const std::filesystem::path& folder);

/// Rehearses the scenario of a wave with a new arm: what fails is a note, as home, payload or torque limits were
/// guessed. What cannot do it and can move its joints one after the other, such as a finger of a hand, gets a scenario
/// of that in its folder, wave.json, and a note of the first failure, with the number of the others.
/// @param root  where scenarios/wave.json is; without one nothing is tried
void try_wave(const std::filesystem::path& folder, const device::ModelLibrary& library,
              const std::filesystem::path& root, std::vector<ImportNote>& notes);

}  // namespace takt::tools
