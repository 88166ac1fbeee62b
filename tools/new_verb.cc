// new: a model folder from a URDF of somebody else, a scenario to begin with.
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tools/cli.h"
#include "tools/import/import_robot.h"
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
  fmt::print("  takt run scenarios/wave.json {} --set /devices/arm/model={}\n", models, options.name);
}

int new_robot(const ImportOptions& options, const Common& common) {
  const auto made = import_robot(options);
  if (!made) return report(made.error(), common);
  if (common.json) {
    print(report_json(*made));
  } else {
    print_text(*made, options);
  }
  return kHeld;
}

int make_scenario(const ImportOptions& options, const std::string& arm, const Common& common) {
  const ScenarioOptions wanted{.name = options.name, .arm = arm, .out = options.out};
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

int missing_urdf(const Common& common) {
  Diagnostics diagnostics;
  diagnostics.error(Code::kMissing, "--urdf", "a robot is made from a URDF file", "--urdf FILE");
  return report(diagnostics, common);
}

}  // namespace

std::pair<CLI::App*, Verb> add_new(CLI::App& app, Common& common) {
  auto options = std::make_shared<ImportOptions>();
  auto what = std::make_shared<std::string>();
  auto arm = std::make_shared<std::string>(ScenarioOptions{}.arm);
  CLI::App* verb = app.add_subcommand("new", "Make a model folder from a foreign URDF, or a scenario to begin with");
  verb->add_option("WHAT", *what, "robot or scenario")->required()->check(CLI::IsMember({"robot", "scenario"}));
  verb->add_option("NAME", options->name, "Name of the model: a-z, 0-9, _; of the scenario file without .json")
      ->required();
  verb->add_option("--urdf", options->urdf, "Of a robot: URDF file to start from")->type_name("FILE");
  verb->add_option("--out", options->out, "Folder for it; default of a robot: models, of a scenario: this one")
      ->type_name("DIR");
  verb->add_option("--arm", *arm, "Of a scenario: model of its arm")->type_name("NAME")->capture_default_str();
  verb->add_option("--packages", options->packages, "Folders with mesh packages, besides those above the file")
      ->type_name("DIR");
  verb->add_option("--base", options->base, "Link at the mounting face; default: guessed")->type_name("LINK");
  verb->add_option("--flange", options->flange, "Link at the face of the flange; default: guessed")->type_name("LINK");
  verb->add_option("--title", options->title, "Title for people")->type_name("TEXT");
  return {verb, [options, what, arm, &common] {
            if (*what == "scenario") return make_scenario(*options, *arm, common);
            if (options->urdf.empty()) return missing_urdf(common);
            if (options->out.empty()) options->out = "models";
            return new_robot(*options, common);
          }};
}

}  // namespace takt::tools
