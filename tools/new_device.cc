#include "tools/new_device.h"

#include <fmt/format.h>
#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/base/json_lines.h"
#include "core/base/json_numbers.h"
#include "core/device/device_file.h"
#include "tools/import/node.h"
#include "tools/import/workshop.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

void add_material(Node& robot, const char* name, const char* rgba) {
  Node& material = robot.add("material");
  material.set("name", std::string(name));
  material.add("color").set("rgba", std::string(rgba));
}

/// A link of mass m whose shape is a box, seen and touched.
void add_box(Node& robot, const std::string& name, const Vector3d& size, const Vector3d& at, double mass,
             const char* material) {
  Node& link = robot.add("link");
  link.set("name", name);
  Node& inertial = link.add("inertial");
  inertial.set_origin(at, Vector3d::Zero());
  inertial.add("mass").set("value", mass);
  Node& inertia = inertial.add("inertia");
  const Vector3d square = size.cwiseProduct(size), I = mass / 12.0 * (Vector3d::Constant(square.sum()) - square);
  for (const auto& [key, value] :
       {std::pair("ixx", I.x()), {"iyy", I.y()}, {"izz", I.z()}, {"ixy", 0.0}, {"ixz", 0.0}, {"iyz", 0.0}})
    inertia.set(key, value);
  for (const char* kind : {"visual", "collision"}) {
    Node& shape = link.add(kind);
    shape.set_origin(at, Vector3d::Zero());
    shape.add("geometry").add("box").set("size", size);
    if (kind == std::string_view("visual")) shape.add("material").set("name", std::string(material));
  }
}

void join(Node& robot, const std::string& name, const char* type, const std::string& parent, const std::string& child) {
  Node& joint = robot.add("joint");
  joint.set("name", name);
  joint.set("type", std::string(type));
  joint.add("parent").set("link", parent);
  joint.add("child").set("link", child);
}

void add_tcp(Node& robot, const std::string& parent, double z) {
  robot.add("link").set("name", std::string("tcp"));
  join(robot, "tcp_mount", "fixed", parent, "tcp");
  robot.children.back().set_origin(Vector3d(0, 0, z), Vector3d::Zero());
}

Node robot_of(const DeviceOptions& options) {
  Node robot{.name = "robot", .attributes = {}, .children = {}};
  robot.set("name", options.name);
  add_material(robot, "grey", "0.62 0.64 0.67 1");
  add_material(robot, "dark", "0.16 0.17 0.18 1");
  return robot;
}

Json device_of(const DeviceOptions& options, const char* kind) {
  return {{"kind", kind},
          {"name", options.name},
          {"title", options.title.empty() ? options.name : options.title},
          {"urdf", options.name + ".urdf"},
          {"base", "base"},
          {"tcp", "tcp"}};
}

/// A foot and a pin.
Node tool_urdf(const DeviceOptions& options) {
  Node robot = robot_of(options);
  const double foot = 0.2 * options.length_m, wide = 0.5 * options.length_m, pin = 0.1 * options.length_m;
  add_box(robot, "base", {wide, wide, foot}, {0, 0, foot / 2}, 0.7 * options.mass_kg, "dark");
  add_box(robot, "pin", {pin, pin, options.length_m - foot}, {0, 0, (options.length_m + foot) / 2},
          0.3 * options.mass_kg, "grey");
  join(robot, "pin_mount", "fixed", "base", "pin");
  add_tcp(robot, "base", options.length_m);
  return robot;
}

/// A body with two fingers that open along x.
Node gripper_urdf(const DeviceOptions& options) {
  Node robot = robot_of(options);
  const double body = 0.55 * options.length_m, finger = options.length_m - body, deep = 0.2 * options.length_m;
  add_box(robot, "base", {options.stroke_m + 2.0 * deep, 1.5 * deep, body}, {0, 0, body / 2}, 0.8 * options.mass_kg,
          "dark");
  for (const auto& [name, side] : {std::pair("finger_left", 1.0), {"finger_right", -1.0}}) {
    add_box(robot, name, {0.5 * deep, 0.75 * deep, finger}, {side * 0.25 * deep, 0, body + finger / 2},
            0.1 * options.mass_kg, "grey");
    join(robot, name, "prismatic", "base", name);
    Node& joint = robot.children.back();
    joint.add("axis").set("xyz", Vector3d(side, 0, 0));
    Node& limit = joint.add("limit");
    limit.set("lower", 0.0);
    limit.set("upper", options.stroke_m / 2);
    limit.set("velocity", 0.1);
    limit.set("effort", options.force_N / 2);
  }
  add_tcp(robot, "base", options.length_m - 0.3 * finger);
  return robot;
}

std::string readme_of(const DeviceOptions& options, const char* kind, const std::string& assumed) {
  return fmt::format(
      "# {}\n\nMade by `takt new {}`. Frames: `base` = robot side, z out; `tcp` = tool centre point. All figures below "
      "were given or assumed: put in those of the data sheet, and write the source beside each.\n\n"
      "| figure | value | why |\n|---|---|---|\n| length | {:g} m | given, or the default |\n"
      "| mass | {:g} kg | given, or the default; inertias are those of uniform boxes |\n{}",
      options.title.empty() ? options.name : options.title, kind, options.length_m, options.mass_kg, assumed);
}

Result<fs::path> make(const DeviceOptions& options, const Node& urdf, const Json& device, const std::string& readme) {
  const Workshop workshop(options.out, options.name);
  if (workshop.folder().empty())
    return failure(Code::kFileNotWritable, "--out", fmt::format("cannot write '{}'", options.out.string()));
  for (const auto& [file, content] : {std::pair(options.name + ".urdf", xml_of(urdf)),
                                      {"device.json", in_lines(without_noise(device)) + "\n"},
                                      {"README.md", readme}})
    if (auto written = workshop.write(file, content); !written) return std::unexpected(written.error());
  const bool is_gripper = device.at("kind") == "gripper";
  Diagnostics wrong;
  if (is_gripper) {
    if (const auto read = device::read_gripper(workshop.folder()); !read) wrong = read.error();
  } else if (const auto read = device::read_tool(workshop.folder()); !read) {
    wrong = read.error();
  }
  if (wrong.has_errors()) return std::unexpected(std::move(wrong));
  if (auto moved = workshop.move_in(); !moved) return std::unexpected(moved.error());
  return options.out / options.name;
}

}  // namespace

Diagnostics check(const DeviceOptions& options) {
  Diagnostics diagnostics = check_new_model(options.out, options.name);
  const auto limit = [&](const char* option, double value, double low, double high) {
    if (!(value >= low && value <= high))
      diagnostics.error(Code::kOutOfRange, option, fmt::format("{:g}", value),
                        fmt::format("Choose {:g} to {:g}", low, high));
  };
  limit("--length", options.length_m, 0.03, 1.0);
  limit("--mass", options.mass_kg, 0.01, 50.0);
  limit("--stroke", options.stroke_m, 0.005, 0.5);
  limit("--force", options.force_N, 1.0, 5000.0);
  return diagnostics;
}

Result<fs::path> new_tool(const DeviceOptions& options) {
  if (Diagnostics diagnostics = check(options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  return make(options, tool_urdf(options), device_of(options, "tool"),
              readme_of(options, "tool", "| shape | a foot and a pin | assumed |\n"));
}

Result<fs::path> new_gripper(const DeviceOptions& options) {
  if (Diagnostics diagnostics = check(options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  Json device = device_of(options, "gripper");
  device["fingers"] = {"finger_left", "finger_right"};
  device["speed_m_s"] = {0.005, 0.2};
  device["acceleration_m_s2"] = 2;
  device["force_N"] = {0.05 * options.force_N, options.force_N};
  device["width_resolution_m"] = 1e-5;
  device["finger_inertia_kg"] = 0.2;
  device["pad_friction"] = 0.6;
  device["cycle_ms"] = 8;
  const std::string assumed = fmt::format(
      "| stroke | {:g} m | given, or the default |\n| force | {:g} to {:g} N | the largest given, or the default |\n"
      "| speed, acceleration | 5 to 200 mm/s, 2 m/s2 of width | assumed |\n| friction of the pads | 0.6 | assumed |\n"
      "| inertia of the drive | 0.2 kg a finger | assumed |\n| samples | every 8 ms | assumed |\n",
      options.stroke_m, 0.05 * options.force_N, options.force_N);
  return make(options, gripper_urdf(options), device, readme_of(options, "gripper", assumed));
}

}  // namespace takt::tools
