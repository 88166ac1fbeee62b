#include "core/device/plant_of_model.h"

#include <nlohmann/json.hpp>

#include "core/device/device_file_impl.h"

namespace takt::device {

Result<PlantDescription> read_plant(const ModelDescription& model) {
  if (model.folder.empty()) return PlantDescription{};  // described by a program, without a file
  const auto file = model.folder / kFileName;
  const auto json = read_json(file);
  if (!json) return std::unexpected(json.error());
  Diagnostics diagnostics;
  ObjectReader reader(*json, "", diagnostics);
  PlantDescription plant = read_plant_keys(reader, model.robot.get(), reader.text("kind", ""));
  diagnostics.set_file(file.string());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return plant;
}

}  // namespace takt::device
