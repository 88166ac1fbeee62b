#include "cell/build/cell_collisions.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/expression/believed_shapes.h"
#include "core/kinematics/plane.h"

namespace takt::cell {
namespace {

using collision::CellShapes;

/// What moves is put where the program believes it to be; a mesh that has no hull is left out.
void add_robot(const sim::RobotDescription& robot, const expression::Cell& cell, CellShapes& shapes,
               Diagnostics& diagnostics) {
  const bool stands = robot.mount.parent.empty();
  const Eigen::Isometry3d X_P = stands ? cell.frames.pose(robot.name).value_or(robot.mount.X_P) : robot.mount.X_P;
  const int parent = stands ? -1 : shapes.scene.find(robot.mount.parent);
  const Diagnostics unusable = shapes.scene.add_robot(robot.name, *robot.model, parent, X_P, robot.q);
  for (Diagnostic diagnostic : unusable.list()) {
    diagnostic.severity = Severity::kWarning;
    diagnostic.pointer = robot.pointer;
    diagnostic.message = "not checked for collisions: " + diagnostic.message;
    diagnostics.add(std::move(diagnostic));
  }
}

void add_object(const ObjectEntry& entry, const expression::Cell& cell, CellShapes& shapes) {
  shapes.objects.insert(entry.name);
  if (!entry.fixed) shapes.free_objects.insert(entry.name);
  if (!entry.model.empty()) return;  // with the machines
  const auto known = cell.objects.find(entry.name);
  if (known == cell.objects.end()) return;
  shapes.scene.add_object(entry.name, known->second.parts, -1,
                          cell.frames.pose(entry.name).value_or(Eigen::Isometry3d::Identity()));
}

std::vector<int> joints_of(const CellShapes& shapes, const std::string& device, const std::vector<std::string>& names) {
  std::vector<int> joints;
  for (const std::string& name : names) joints.push_back(shapes.scene.find_joint(device + "/" + name));
  return joints;
}

std::vector<int> bodies_of(const CellShapes& shapes, const std::string& owner) {
  std::vector<int> bodies;
  for (int body = 0; body < static_cast<int>(shapes.scene.bodies().size()); ++body)
    if (shapes.scene.body(body).owner == owner) bodies.push_back(body);
  return bodies;
}

/// Tool sides are parts that changers carry; the two are made to meet.
void add_couplings(const sim::WorldDescription& simulated, CellShapes& shapes) {
  for (const sim::SimToolSideDescription& side : simulated.tool_sides) {
    shapes.objects.insert(side.name);
    shapes.free_objects.insert(side.name);
    for (const sim::SimToolChangerDescription& changer : simulated.tool_changers)
      if (changer.size == side.size)
        for (const int a : bodies_of(shapes, changer.name))
          for (const int b : bodies_of(shapes, side.name)) shapes.couplings.insert(std::minmax(a, b));
  }
}

void find_mechanisms(const expression::Cell& cell, CellShapes& shapes) {
  for (const auto& [name, arm] : cell.arms) {
    const device::ArmDescription& model = arm.device->description();
    shapes.arms[name] = {.joints = joints_of(shapes, name, model.joint_names),
                         .flange = shapes.scene.find(name + "/" + model.flange_link),
                         .is_base = kinematics::moves_in_plane(*model.chain)};
  }
  for (const auto& [name, gripper] : cell.grippers)
    shapes.grippers[name] = joints_of(shapes, name, gripper.device->description().fingers);
}

/// Links that are too near to each other in the home posture of their arm are built so: their solids are hulls.
void accept_home(const expression::Cell& cell, CellShapes& shapes) {
  collision::State home = shapes.scene.start();
  for (const auto& [name, arm] : cell.arms) expression::set_joints(shapes, name, arm.device->description().home, home);
  shapes.scene.accept_as_built(home, shapes.margin);
}

void read_allowed(const CollisionsEntry& entry, CellShapes& shapes, Diagnostics& diagnostics) {
  const std::vector<std::string> names = shapes.names();
  for (const CollisionsEntry::Allowed& one : entry.allow) {
    for (std::size_t i = 0; i < one.between.size(); ++i) {
      if (std::ranges::find(names, one.between[i]) != names.end()) continue;
      diagnostics.error(Code::kUnknownName, one.pointer + "/between" + pointer_segment(i),
                        fmt::format("there is no device, object or body '{}'", one.between[i]),
                        nearest_choice(one.between[i], names));
    }
    shapes.relaxed.push_back({one.between[0], one.between[1], one.reason});
  }
}

}  // namespace

std::shared_ptr<const CellShapes> cell_shapes(const Description& description, const sim::WorldDescription& simulated,
                                              const expression::Cell& cell, Diagnostics& diagnostics) {
  auto shapes = std::make_shared<CellShapes>();
  shapes->margin = description.collisions.margin_m;
  shapes->off = description.collisions.off;
  for (const sim::RobotDescription& robot : simulated.robots) add_robot(robot, cell, *shapes, diagnostics);
  for (const ObjectEntry& entry : description.objects) add_object(entry, cell, *shapes);
  add_couplings(simulated, *shapes);
  shapes->add_floor();
  shapes->scene.find_pairs_that_never_meet();
  find_mechanisms(cell, *shapes);
  accept_home(cell, *shapes);
  read_allowed(description.collisions, *shapes, diagnostics);
  return shapes;
}

}  // namespace takt::cell
