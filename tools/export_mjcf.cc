#include "tools/export_mjcf.h"

#include <fmt/format.h>

#include "cell/build/simulated_cell.h"
#include "core/base/json.h"
#include "core/base/output_file.h"
#include "sim/plain/plain_model.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostMeshBytes = std::size_t{1} << 28;

Result<sim::PlainModel> model_of(const MjcfExport& options, const device::ModelLibrary& library) {
  const auto description = cell::read_description(options.scenario, options.overrides, options.seed);
  if (!description) return std::unexpected(description.error());
  const device::ModelLibrary models = library.beside(options.scenario);
  Diagnostics diagnostics;
  const cell::LoadedCell loaded(*description, models, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const cell::SimulatedCell simulated = cell::simulate(loaded, models, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return sim::plain_model(simulated.world,
                          {.name = options.scenario.stem().string(), .frames = cell::mounted_frames(loaded)});
}

Result<void> make_assets_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && fs::is_directory(folder, error)) return {};
  return failure(Code::kFileNotWritable, "--mjcf", fmt::format("cannot make the folder '{}'", folder.string()),
                 "Name a folder that can be made");
}

}  // namespace

Result<MjcfReport> export_mjcf(const MjcfExport& options, const device::ModelLibrary& library) {
  auto model = model_of(options, library);
  if (!model) {
    model.error().set_file(options.scenario.string());
    return std::unexpected(std::move(model.error()));
  }
  if (auto made = make_assets_folder(options.out / "assets"); !made) return std::unexpected(made.error());
  MjcfReport report{.files = {options.out / (options.scenario.stem().string() + ".xml")},
                    .lacks = std::move(model->lacks)};
  for (const auto& [name, source] : model->assets) {
    const auto content = read_file(source, kMostMeshBytes);
    if (!content) return std::unexpected(content.error());
    report.files.push_back(options.out / "assets" / name);
    if (Diagnostics wrong = write_file(report.files.back(), *content, "--mjcf"); wrong.has_errors())
      return std::unexpected(std::move(wrong));
  }
  // The model last: where it is, its meshes are.
  if (Diagnostics wrong = write_file(report.files.front(), model->mjcf, "--mjcf"); wrong.has_errors())
    return std::unexpected(std::move(wrong));
  return report;
}

}  // namespace takt::tools
