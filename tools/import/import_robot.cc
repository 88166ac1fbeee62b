#include "tools/import/import_robot.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/json_lines.h"
#include "core/base/json_numbers.h"
#include "core/device/device_file.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/urdf_check.h"
#include "core/kinematics/xml_scan.h"
#include "tools/import/device_guess.h"
#include "tools/import/mjcf.h"
#include "tools/import/workshop.h"
#include "tools/import/xacro.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

Diagnostics check_options(const ImportOptions& options) {
  Diagnostics diagnostics = check_new_model(options.out, options.name);
  std::error_code error;
  for (const fs::path& folder : options.packages) {
    if (!fs::is_directory(folder, error))
      diagnostics.error(Code::kNotFound, "--packages", fmt::format("'{}' is not a folder", folder.string()));
  }
  return diagnostics;
}

/// A xacro file may have nothing but expressions and arguments.
bool has_expressions(const std::string& text) {
  return text.find("\"${") != text.npos || text.find("$(arg ") != text.npos || text.find("$(find ") != text.npos ||
         (text.find("xmlns:xacro") != text.npos && text.find("${") != text.npos);
}

Result<Draft> read_foreign_mjcf(const ImportOptions& options) {
  if (!options.xacro.empty())
    return failure(Code::kRequires, "--xacro", "the file is a model of MuJoCo", "Give a xacro file");
  auto draft = read_mjcf(options.file);
  if (!draft) return draft;
  draft->base = options.base;
  draft->flange = options.flange;
  draft->without = options.without;
  draft->note("MJCF", "read by MuJoCo's own compiler", "classes, defaults and includes count as they do there");
  return draft;
}

Result<Draft> read_draft(const ImportOptions& options) {
  auto text = read_file(options.file, kinematics::kMaxXmlBytes);
  if (!text) return std::unexpected(text.error());
  auto tree = kinematics::scan_xml(*text);
  if (!tree) return std::unexpected(tree.error());
  if (tree->elements.front().name == "mujoco") return read_foreign_mjcf(options);
  const bool expand = kinematics::check_no_xacro(*tree).has_errors() || has_expressions(*text);
  if (expand) {
    text = expand_xacro(options.file, {options.packages, options.xacro});
    if (!text) return std::unexpected(text.error());
    tree = kinematics::scan_xml(*text);
    if (!tree) return std::unexpected(tree.error());
  } else if (!options.xacro.empty()) {
    return failure(Code::kRequires, "--xacro", "the file is a plain URDF", "Give a xacro file");
  }
  if (tree->elements.front().name != "robot") {
    return failure(Code::kSyntax, fmt::format("line {}", tree->elements.front().line),
                   fmt::format("the root element is <{}>", tree->elements.front().name),
                   "Begin with <robot>, or with <mujoco>");
  }
  Draft draft;
  draft.robot = node_of(*tree);
  draft.base = options.base;
  draft.flange = options.flange;
  draft.without = options.without;
  if (expand)
    draft.note("xacro", options.xacro.empty() ? "as it is" : fmt::format("{}", fmt::join(options.xacro, ", ")),
               "the file was expanded");
  return draft;
}

Result<void> write_robot(const Draft& draft, const Workshop& workshop, const std::string& name) {
  for (const auto& [path, content] : draft.mesh_files) {
    if (auto written = workshop.write(path, content); !written) return written;
  }
  return workshop.write(name + ".urdf", xml_of(draft.robot));
}

Result<kinematics::RobotModel> load(const fs::path& folder, const std::string& name) {
  return kinematics::RobotModel::load(folder / (name + ".urdf"));
}

/// Torque limits need the whole arm: they are guessed once it stands, and written into the URDF.
void fill_effort(Draft& draft, const kinematics::Chain& chain) {
  const std::vector<double> effort = guess_effort(chain, armature_of(chain, draft));
  std::map<std::string, std::string> why;
  for (const Placeholder& one : placeholder_efforts(chain)) {
    const std::string& name = chain.joint_names()[static_cast<std::size_t>(one.joint)];
    if (std::ranges::find(draft.without_effort, name) != draft.without_effort.end()) continue;
    draft.without_effort.push_back(name);
    why[name] = fmt::format(
        "WARNING: the file has {:g}, a placeholder: holding the arm takes up to {:.3g}; twice that, and 8 rad/s2",
        one.effort, one.holding);
  }
  for (std::size_t i = 0; i < effort.size(); ++i) {
    const std::string& name = chain.joint_names()[i];
    if (std::ranges::find(draft.without_effort, name) == draft.without_effort.end()) continue;
    for (Node* joint : draft.robot.all("joint")) {
      if (joint->text("name") == name) joint->need("limit").set("effort", effort[i]);
    }
    draft.note(fmt::format("joint '{}' limit effort", name),
               fmt::format("{:g} {}", effort[i], chain.is_prismatic(static_cast<int>(i)) ? "N" : "Nm"),
               why.contains(name) ? why.at(name)
                                  : "the file has none; twice what holding the arm costs at most, and 8 rad/s2");
  }
}

std::string readme(const ImportOptions& options, const Draft& draft) {
  std::string text = fmt::format(
      "# {}\n\nMade by `takt new robot` from `{}`. Base: `{}`, flange: `{}` (z out of the face).\n\n"
      "Where a figure is not in this table, it comes from that file. All below was guessed, replaced or left out: "
      "check "
      "it against the maker's data sheet, and write the source beside it.\n\n| what | value | why |\n|---|---|---|\n",
      options.title.empty() ? options.name : options.title, options.file.filename().string(), draft.base, draft.flange);
  for (const ImportNote& note : draft.notes) text += fmt::format("| {} | {} | {} |\n", note.key, note.value, note.why);
  return text;
}

/// The device file and the readers' verdict. @return whether the trial had nothing to say.
Result<bool> try_device(const ImportOptions& options, const kinematics::RobotModel& robot,
                        const kinematics::Chain& chain, Draft& draft, const Workshop& workshop) {
  nlohmann::ordered_json device = guess_device(options.name, robot, chain, draft);
  if (!options.title.empty()) device["title"] = options.title;
  if (auto written = workshop.write("device.json", in_lines(without_noise(device)) + "\n"); !written)
    return std::unexpected(written.error());
  const auto arm = device::read_arm(workshop.folder());
  if (!arm) return std::unexpected(arm.error());
  const std::size_t before = draft.notes.size();
  if (options.trial)
    if (auto tried = options.trial(workshop.folder(), draft.notes); !tried) return std::unexpected(tried.error());
  return draft.notes.size() == before;
}

/// With the home of the file; where the trial does not pass from there, and does from the one that is guessed, that
/// one.
Result<void> make_device(const ImportOptions& options, const kinematics::RobotModel& robot,
                         const kinematics::Chain& chain, Draft& draft, const Workshop& workshop) {
  const std::vector<ImportNote> notes = draft.notes;
  const auto passed = try_device(options, robot, chain, draft, workshop);
  if (!passed) return std::unexpected(passed.error());
  if (*passed || draft.home.empty()) return {};
  std::string values;
  for (const std::string& joint : chain.joint_names()) {
    const auto known = draft.extras.find(joint);
    if (known == draft.extras.end() || !known->second.home) continue;
    values += fmt::format("{}{:.6g}", values.empty() ? "[" : ", ", *known->second.home);
  }
  if (values.empty()) return {};
  values += "]";
  // What was made so far comes back if the other home is no better.
  std::map<std::string, std::string> files;
  for (const char* name : {"device.json", "wave.json"})
    if (auto text = read_file(workshop.folder() / name, kinematics::kMaxXmlBytes)) files[name] = std::move(*text);
  const std::vector<ImportNote> with_home = std::exchange(draft.notes, notes);
  const std::string home = std::exchange(draft.home, "");
  draft.note(home, fmt::format("{} is not the home", values),
             "the wave does not pass from there, and does from the one that was guessed");
  const auto other = try_device(options, robot, chain, draft, workshop);
  if (other && *other) return {};
  draft.home = home;
  draft.notes = with_home;
  for (const auto& [name, text] : files)
    if (auto written = workshop.write(name, text); !written) return written;
  return {};
}

/// The device file, and the README.
Result<void> finish(const ImportOptions& options, Draft& draft, const Workshop& workshop) {
  const fs::path& folder = workshop.folder();
  const auto robot = load(folder, options.name);
  if (!robot) return std::unexpected(robot.error());
  const auto chain = kinematics::Chain::create(*robot, draft.base, draft.flange);
  if (!chain) return std::unexpected(chain.error());
  if (chain->joint_count() < 3) {
    return failure(Code::kInvalidValue, "",
                   fmt::format("between '{}' and '{}' there are {} movable joints", draft.base, draft.flange,
                               chain->joint_count()),
                   "Choose links with 3 to 12 joints between them for an arm");
  }
  auto made = make_device(options, *robot, *chain, draft, workshop);
  if (!made) return std::unexpected(made.error());
  return workshop.write("README.md", readme(options, draft));
}

Result<void> build(const ImportOptions& options, Draft& draft, const Workshop& workshop) {
  clean(draft, options.name);
  complete_joints(draft);
  gather_meshes(draft, MeshPaths(options.file, options.packages));
  guess_chain(draft);
  if (draft.diagnostics.has_errors()) return std::unexpected(draft.diagnostics);
  complete_bodies(draft);
  if (auto written = write_robot(draft, workshop, options.name); !written) return written;
  const auto robot = load(workshop.folder(), options.name);
  if (!robot) return std::unexpected(robot.error());
  const auto chain = kinematics::Chain::create(*robot, draft.base, draft.flange);
  if (!chain) return std::unexpected(chain.error());
  fill_effort(draft, *chain);
  if (auto written = write_robot(draft, workshop, options.name); !written) return written;
  return finish(options, draft, workshop);
}

/// Movable joints from the base to the flange: the order of the device file.
std::vector<std::string> joints_of(Draft& draft) {
  std::vector<std::string> names;
  for (std::string link = draft.flange; link != draft.base;) {
    const Node* joint = draft.joint_above(link);
    if (joint == nullptr) break;
    if (is_movable(*joint)) names.push_back(joint->text("name"));
    link = parent_of(*joint);
  }
  std::ranges::reverse(names);
  return names;
}

}  // namespace

Result<ImportReport> import_robot(const ImportOptions& options) {
  if (Diagnostics diagnostics = check_options(options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  auto draft = read_draft(options);
  if (!draft) {
    draft.error().set_file(options.file.string());
    return std::unexpected(draft.error());
  }
  // All is made beside its place and moved there when it is whole.
  const Workshop workshop(options.out, options.name);
  if (workshop.folder().empty())
    return failure(Code::kFileNotWritable, "--out", fmt::format("cannot write '{}'", options.out.string()));
  auto built = build(options, *draft, workshop);
  if (built) {
    if (auto moved = workshop.move_in(); !moved) return std::unexpected(moved.error());
  }
  if (!built) {
    Diagnostics diagnostics;
    for (Diagnostic diagnostic : built.error().list()) {
      // The user's file is the one to mend; its lines are not those of the file that was made from it.
      diagnostic.file = options.file.string();
      if (diagnostic.pointer.starts_with("line ")) diagnostic.pointer.clear();
      diagnostics.add(std::move(diagnostic));
    }
    return std::unexpected(std::move(diagnostics));
  }
  return ImportReport{options.out / options.name, draft->base, draft->flange, joints_of(*draft), draft->notes};
}

}  // namespace takt::tools
