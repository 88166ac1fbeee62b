// new: a model folder from a URDF or MJCF of somebody else or from a mesh, a scenario to begin with.
#include <cctype>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/device/material.h"
#include "tools/cli.h"
#include "tools/import/import_object.h"
#include "tools/import/import_robot.h"
#include "tools/model_trial.h"
#include "tools/new_device.h"
#include "tools/new_scenario.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

Json report_json(const ImportReport& report) {
  Json notes = Json::array();
  for (const ImportNote& note : report.notes) {
    notes.push_back({{"key", note.key}, {"value", note.value}, {"why", note.why}});
  }
  return {{"result", "made"},        {"folder", report.folder.string()}, {"base", report.base},
          {"flange", report.flange}, {"joints", report.joints},          {"notes", notes}};
}

void print_text(const ImportReport& report, const ImportOptions& options) {
  fmt::print("{}: base '{}', flange '{}', joints {}\n", report.folder.string(), report.base, report.flange,
             fmt::join(report.joints, ", "));
  fmt::print("guessed, replaced or left out:\n");
  for (const ImportNote& note : report.notes) fmt::print("  {}: {} ({})\n", note.key, note.value, note.why);
  const std::string models = fmt::format("--models {}", options.out.string());
  fmt::print("next:\n  takt validate {}/device.json\n  takt model {} {} --image {}.png\n", report.folder.string(),
             options.name, models, options.name);
  std::error_code error;
  if (const auto own = report.folder / "wave.json"; std::filesystem::exists(own, error)) {
    fmt::print("  takt run {} {}\n", own.string(), models);
  } else {
    fmt::print("  takt run scenarios/wave.json {} --set /devices/arm/model={}\n", models, options.name);
  }
}

/// "arms/UR5-e.xml" in place of a name: the file, which names the model "ur5_e".
void name_by_file(ImportOptions& options) {
  const std::filesystem::path file = options.name;
  const std::string extension = file.extension().string();
  if (!options.file.empty() || (extension != ".xml" && extension != ".urdf" && extension != ".xacro")) return;
  options.file = file;
  options.name.clear();
  for (const char c : file.stem().string())
    options.name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? static_cast<char>(std::tolower(c)) : '_';
}

int new_robot(const ImportOptions& given, const Common& common) {
  ImportOptions wanted = given;
  name_by_file(wanted);
  if (wanted.file.empty())
    return report(failure(Code::kMissing, "--urdf", "no file is given", "Give --urdf FILE or --mjcf FILE").error(),
                  common);
  ImportOptions options = wanted;
  options.trial = [&common](const std::filesystem::path& folder, std::vector<ImportNote>& notes) -> Result<void> {
    Diagnostics diagnostics = check_model(folder);
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    try_wave(folder, device::ModelLibrary({folder.parent_path(), common.root / "models"}), common.root, notes);
    return {};
  };
  const auto made = import_robot(options);
  if (!made) return report(made.error(), common);
  if (common.json) {
    print(report_json(*made));
  } else {
    print_text(*made, options);
  }
  return kHeld;
}

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

int new_object(const ObjectOptions& options, const Common& common) {
  Diagnostics diagnostics = check(options);
  if (!options.material.empty()) {
    const auto materials = device::read_materials(common.library());
    if (!materials) return report(materials.error(), common);
    (void)materials->find(options.material, "--material", diagnostics);
  }
  if (diagnostics.has_errors()) return report(diagnostics, common);
  const auto made = import_object(options);
  if (!made) return report(made.error(), common);
  if (common.json) {
    Json notes = Json::array();
    for (const ImportNote& note : made->notes)
      notes.push_back({{"key", note.key}, {"value", note.value}, {"why", note.why}});
    print({{"result", "made"},
           {"folder", made->folder.string()},
           {"parts", made->parts},
           {"filled_share", made->filled},
           {"mass_kg", made->mass},
           {"centre_m", vector_json(made->centre_m)},
           {"size_m", vector_json(made->size_m)},
           {"notes", std::move(notes)}});
    return kHeld;
  }
  fmt::print("{}: {:.3f} x {:.3f} x {:.3f} m, {:.4g} kg, fills {:.0f} % of its convex hull; {} convex part{}\n",
             made->folder.string(), made->size_m.x(), made->size_m.y(), made->size_m.z(), made->mass,
             100.0 * made->filled, made->parts, made->parts == 1 ? "" : "s");
  for (const ImportNote& note : made->notes) fmt::print("  {}: {} ({})\n", note.key, note.value, note.why);
  fmt::print("next:\n  takt model {0} --models {1} --image {0}.png\n", options.name, options.out.string());
  fmt::print("  \"{0}\": {{\"model\": \"{0}\", \"fixed\": false, \"at\": {{...}}}} in \"objects\" of a scenario\n",
             options.name);
  return kHeld;
}

void add_object_options(CLI::App& verb, ObjectOptions& object) {
  verb.add_option("--mesh", object.mesh, "Of an object: its surface, .stl, .obj or .dae")->type_name("FILE");
  verb.add_option("--scale", object.scale, "Length of one unit of the mesh, m; default: 1")->type_name("M");
  auto* mass = verb.add_option("--mass", object.mass, "Of the object, tool or gripper")->type_name("KG");
  verb.add_option("--density", object.density, "In place of a mass, kg/m3; default: 1000")
      ->type_name("D")
      ->excludes(mass);
  verb.add_option("--material", object.material, "Of its surface; default: steel")->type_name("NAME");
  verb.add_option("--concavity", object.split.concavity,
                  "Of a convex part at most: 0.01 many parts, 1 the convex hull; default: 0.05")
      ->type_name("C");
  verb.add_option("--most-parts", object.split.most_parts, "Convex parts at most; default: 64")->type_name("N");
}

int make_scenario(const ImportOptions& options, const std::string& arm, const Common& common) {
  const ScenarioOptions wanted{
      .name = options.name, .arm = arm, .out = options.out, .schema = common.root / "schemas/scenario.schema.json"};
  const auto file = new_scenario(wanted, common.library());
  if (!file) return report(file.error(), common);
  if (common.json) {
    print({{"result", "made"}, {"file", file->string()}});
  } else {
    fmt::print("{}\nnext:\n  takt validate {}\n  takt run {} --video {}.mp4\n", file->string(), file->string(),
               file->string(), options.name);
  }
  return kHeld;
}

int make_device(const std::string& what, const DeviceOptions& options, const Common& common) {
  const auto folder = what == "tool" ? new_tool(options) : new_gripper(options);
  if (!folder) return report(folder.error(), common);
  if (common.json) {
    print({{"result", "made"}, {"folder", folder->string()}});
    return kHeld;
  }
  fmt::print("{}\nnext:\n  takt validate {}/device.json\n", folder->string(), folder->string());
  fmt::print("  takt model {0} --models {1} --image {0}.png\n", options.name, options.out.string());
  fmt::print("  \"{0}\": {{\"model\": \"{0}\", \"on\": \"arm\"}} in \"devices\" of a scenario\n", options.name);
  return kHeld;
}

void add_device_options(CLI::App& verb, DeviceOptions& device) {
  verb.add_option("--length", device.length_m, "Of a tool or gripper, from the mounting face to the tip; default: 0.15")
      ->type_name("M");
  verb.add_option("--stroke", device.stroke_m, "Of a gripper: between the open fingers; default: 0.1")->type_name("M");
  verb.add_option("--force", device.force_N, "Of a gripper: the largest grasping force; default: 100")->type_name("N");
}

}  // namespace

std::pair<CLI::App*, Verb> add_new(CLI::App& app, Common& common) {
  auto options = std::make_shared<ImportOptions>();
  auto object = std::make_shared<ObjectOptions>();
  auto what = std::make_shared<std::string>();
  auto arm = std::make_shared<std::string>(ScenarioOptions{}.arm);
  CLI::App* verb = app.add_subcommand("new",
                                      "Make a model folder from a foreign URDF or MJCF, or of a thing from its mesh; a "
                                      "tool, a gripper, a scenario to begin with");
  verb->add_option("WHAT", *what, "robot, object, tool, gripper or scenario")
      ->required()
      ->check(CLI::IsMember({"robot", "object", "tool", "gripper", "scenario"}));
  verb->add_option(
          "NAME", options->name,
          "Name of the model: a-z, 0-9, _; of the scenario file without .json; of a robot also its file, which then "
          "names it")
      ->required();
  auto* urdf = verb->add_option("--urdf", options->file, "Of a robot: the URDF or xacro file to start from");
  urdf->type_name("FILE");
  verb->add_option("--mjcf", options->file, "Of a robot: the model of MuJoCo (MJCF) to start from")
      ->type_name("FILE")
      ->excludes(urdf);
  verb->add_option("--out", options->out, "Folder for it; default of a model: models, of a scenario: this one")
      ->type_name("DIR");
  verb->add_option("--arm", *arm, "Of a scenario: model of its arm")->type_name("NAME")->capture_default_str();
  verb->add_option("--packages", options->packages, "Folders with mesh packages, besides those above the file")
      ->type_name("DIR");
  verb->add_option("--xacro", options->xacro, "Of a robot from a xacro file: the value of an argument; several times")
      ->type_name("NAME:=VALUE")
      ->allow_extra_args(false);
  verb->add_option("--base", options->base, "Link at the mounting face; default: guessed")->type_name("LINK");
  verb->add_option("--flange", options->flange, "Link at the face of the flange; default: guessed")->type_name("LINK");
  verb->add_option("--without", options->without,
                   "Of a robot: leave out this link and all that hangs on it, such as a gripper; several times")
      ->type_name("LINK")
      ->allow_extra_args(false);
  verb->add_option("--title", options->title, "Title for people")->type_name("TEXT");
  add_object_options(*verb, *object);
  auto device = std::make_shared<DeviceOptions>();
  add_device_options(*verb, *device);
  return {verb, [options, object, device, what, arm, &common] {
            if (*what == "scenario") return make_scenario(*options, *arm, common);
            if (options->out.empty()) options->out = "models";
            if (*what == "robot") return new_robot(*options, common);
            if (*what == "tool" || *what == "gripper") {
              device->name = options->name;
              device->out = options->out;
              device->title = options->title;
              device->mass_kg = object->mass.value_or(device->mass_kg);
              return make_device(*what, *device, common);
            }
            object->name = options->name;
            object->out = options->out;
            object->title = options->title;
            return new_object(*object, common);
          }};
}

}  // namespace takt::tools
