#include "tools/import/import_object.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json_lines.h"
#include "core/base/json_numbers.h"
#include "core/device/material.h"
#include "core/kinematics/robot_model.h"
#include "tools/import/workshop.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Solid {
  Triangles surface;  ///< in m
  std::vector<Triangles> parts;
  SolidFigures figures;  ///< of the surface where it is closed, else of the parts
  double mass = 0.0;
};

void scale(Triangles& mesh, double factor) {
  for (Eigen::Vector3d& p : mesh.points) p *= factor;
}

/// Where the triangles are turned inside out, the right way round.
void turn_outwards(Triangles& mesh) {
  if (solid_figures(mesh).volume >= 0.0) return;
  for (auto& face : mesh.faces) std::swap(face[1], face[2]);
}

/// Of all parts together; where they overlap, that counts twice.
SolidFigures sum_of(const std::vector<Triangles>& parts) {
  Triangles all;
  for (const Triangles& part : parts) {
    const int first = static_cast<int>(all.points.size());
    all.points.insert(all.points.end(), part.points.begin(), part.points.end());
    for (const auto& face : part.faces) all.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
  }
  return solid_figures(all);
}

Result<Solid> solid_of(const ObjectOptions& options, std::vector<ImportNote>& notes) {
  const auto file = read_mesh(options.mesh);
  if (!file) return std::unexpected(file.error());
  auto surface = triangles_of(*file);
  if (!surface) return std::unexpected(surface.error());
  Solid solid{.surface = std::move(*surface), .parts = {}, .figures = {}};
  scale(solid.surface, options.scale);
  turn_outwards(solid.surface);
  auto parts = convex_parts(solid.surface, options.split);
  if (!parts) return std::unexpected(parts.error());
  solid.parts = std::move(*parts);
  const bool closed = solid.surface.closed();
  solid.figures = closed ? solid_figures(solid.surface) : sum_of(solid.parts);
  if (!closed)
    notes.push_back({"surface", "not closed", "split after it was closed from voxels; masses are those of the parts"});
  solid.mass = options.mass.value_or(options.density * solid.figures.volume);
  if (!options.mass)
    notes.push_back({"mass", fmt::format("{:.4g} kg", solid.mass), fmt::format("{:g} kg/m3", options.density)});
  return solid;
}

void add_mesh(Node& link, const char* kind, const std::string& file) {
  link.children.push_back({.name = kind, .attributes = {}, .children = {}});
  link.children.back().add("geometry").add("mesh").set("filename", file);
}

Node urdf_of(const ObjectOptions& options, const Solid& solid) {
  Node robot{.name = "robot", .attributes = {}, .children = {}};
  robot.set("name", options.name);
  Node& link = robot.add("link");
  link.set("name", "base");
  Node& inertial = link.add("inertial");
  inertial.set_origin(solid.figures.centre, Eigen::Vector3d::Zero());
  inertial.add("mass").set("value", solid.mass);
  const Eigen::Matrix3d I = solid.mass / solid.figures.volume * solid.figures.inertia;
  Node& inertia = inertial.add("inertia");
  for (const auto& [key, value] : {std::pair("ixx", I(0, 0)),
                                   {"ixy", I(0, 1)},
                                   {"ixz", I(0, 2)},
                                   {"iyy", I(1, 1)},
                                   {"iyz", I(1, 2)},
                                   {"izz", I(2, 2)}})
    inertia.set(key, value);
  add_mesh(link, "visual", "meshes/surface.obj");
  for (std::size_t i = 0; i < solid.parts.size(); ++i)
    add_mesh(link, "collision", fmt::format("meshes/part_{}.obj", i + 1));
  return robot;
}

std::string object_readme(const ObjectOptions& options, const ObjectReport& report) {
  std::string text = fmt::format(
      "# {}\n\nMade by `takt new object` from `{}`. The frame `base` is that of the mesh file, {:g} m a unit. The mesh "
      "is "
      "what is seen; {} convex part{} of it {} what collides.\n\nAll below was computed or assumed: check it, and "
      "write "
      "the source beside it.\n\n| what | value | why |\n|---|---|---|\n",
      options.title.empty() ? options.name : options.title, options.mesh.filename().string(), options.scale,
      report.parts, report.parts == 1 ? "" : "s", report.parts == 1 ? "is" : "are");
  for (const ImportNote& note : report.notes) text += fmt::format("| {} | {} | {} |\n", note.key, note.value, note.why);
  return text;
}

Result<void> write_all(const ObjectOptions& options, const Solid& solid, const ObjectReport& report,
                       const Workshop& workshop) {
  Json device{{"kind", "object"}, {"name", options.name}};
  device["title"] = options.title.empty() ? options.name : options.title;
  device["urdf"] = options.name + ".urdf";
  device["base"] = "base";
  if (!options.material.empty()) device["material"] = options.material;
  std::vector<std::pair<fs::path, std::string>> files{{options.name + ".urdf", xml_of(urdf_of(options, solid))},
                                                      {"device.json", in_lines(without_noise(device)) + "\n"},
                                                      {"README.md", object_readme(options, report)},
                                                      {"meshes/surface.obj", obj_of(solid.surface)}};
  for (std::size_t i = 0; i < solid.parts.size(); ++i)
    files.emplace_back(fmt::format("meshes/part_{}.obj", i + 1), obj_of(solid.parts[i]));
  for (const auto& [file, content] : files)
    if (auto written = workshop.write(file, content); !written) return written;
  return {};
}

ObjectReport report_of(const ObjectOptions& options, const Solid& solid, std::vector<ImportNote> notes) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : solid.surface.points) box.extend(p);
  return {.folder = options.out / options.name,
          .parts = solid.parts.size(),
          .filled = std::min(1.0, solid.figures.volume / hull_volume(solid.surface).value_or(solid.figures.volume)),
          .mass = solid.mass,
          .centre_m = solid.figures.centre,
          .size_m = box.sizes(),
          .notes = std::move(notes)};
}

}  // namespace

Diagnostics check(const ObjectOptions& options) {
  Diagnostics diagnostics = check_new_model(options.out, options.name);
  std::error_code error;
  if (!fs::is_regular_file(options.mesh, error))
    diagnostics.error(Code::kFileNotReadable, "--mesh", fmt::format("there is no file '{}'", options.mesh.string()),
                      "Name a mesh, .stl or .obj");
  const auto limit = [&](const char* option, double value, double low, double high) {
    if (!(value >= low && value <= high))
      diagnostics.error(Code::kOutOfRange, option, fmt::format("{:g}", value),
                        fmt::format("Choose {:g} to {:g}", low, high));
  };
  limit("--scale", options.scale, 1e-6, 1e3);
  limit("--mass", options.mass.value_or(1.0), 1e-6, 1e5);
  limit("--density", options.density, 0.1, 3e4);
  limit("--concavity", options.split.concavity, 0.01, 1.0);
  limit("--most-parts", options.split.most_parts, 1, 256);
  return diagnostics;
}

Result<ObjectReport> import_object(const ObjectOptions& options) {
  if (Diagnostics diagnostics = check(options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  std::vector<ImportNote> notes;
  auto solid = solid_of(options, notes);
  if (!solid) {
    solid.error().set_file(options.mesh.string());
    return std::unexpected(solid.error());
  }
  ObjectReport report = report_of(options, *solid, std::move(notes));
  constexpr double kHuge = 10.0;  // m
  if (options.scale == 1.0 && report.size_m.maxCoeff() > kHuge)
    report.notes.push_back({"size", fmt::format("{:.4g} m", report.size_m.maxCoeff()),
                            "WARNING: of a mesh in millimetres? --scale 0.001"});
  const Workshop workshop(options.out, options.name);
  if (workshop.folder().empty())
    return failure(Code::kFileNotWritable, "--out", fmt::format("cannot write '{}'", options.out.string()));
  if (auto written = write_all(options, *solid, report, workshop); !written) return std::unexpected(written.error());
  const auto robot = kinematics::RobotModel::load(workshop.folder() / (options.name + ".urdf"));
  if (!robot) return std::unexpected(robot.error());
  if (auto moved = workshop.move_in(); !moved) return std::unexpected(moved.error());
  return report;
}

}  // namespace takt::tools
