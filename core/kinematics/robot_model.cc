#include "core/kinematics/robot_model.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <map>
#include <mutex>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include "core/base/json.h"
#include "core/kinematics/urdf_check.h"
#include "core/kinematics/xml_scan.h"

namespace takt::kinematics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What urdfdom prints becomes diagnostics while this lives. The handler is global to the process, hence the lock.
class CapturedConsole : public console_bridge::OutputHandler {
 public:
  explicit CapturedConsole(Diagnostics& diagnostics) : diagnostics_(diagnostics) {
    console_bridge::useOutputHandler(this);
  }
  ~CapturedConsole() override { console_bridge::restorePreviousOutputHandler(); }
  CapturedConsole(const CapturedConsole&) = delete;
  CapturedConsole& operator=(const CapturedConsole&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) {
      diagnostics_.error(Code::kInvalidModel, {}, text);
    } else if (level >= console_bridge::CONSOLE_BRIDGE_LOG_WARN) {
      diagnostics_.warning(Code::kInvalidModel, {}, text);
    }
  }

 private:
  static std::mutex& console_mutex() {
    static std::mutex mutex;
    return mutex;
  }
  std::lock_guard<std::mutex> lock_{console_mutex()};
  Diagnostics& diagnostics_;
};

urdf::ModelInterfaceSharedPtr parse_with_urdfdom(const std::string& xml, Diagnostics& diagnostics) {
  const CapturedConsole console(diagnostics);
  try {
    auto model = urdf::parseURDF(xml);
    if (model == nullptr && !diagnostics.has_errors())
      diagnostics.error(Code::kSyntax, {}, "urdfdom refuses the file without a reason");
    return model;
  } catch (const std::exception& error) {
    diagnostics.error(Code::kInvalidModel, {}, fmt::format("urdfdom: {}", error.what()));
  }
  return nullptr;
}

Eigen::Vector3d to_eigen(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Eigen::Isometry3d to_eigen(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
  X.translation() = to_eigen(pose.position);
  return X;
}

Inertial to_inertial(const urdf::Inertial& source) {
  Inertial inertial{source.mass, to_eigen(source.origin), {}};
  inertial.I_C << source.ixx, source.ixy, source.ixz,  //
      source.ixy, source.iyy, source.iyz,              //
      source.ixz, source.iyz, source.izz;
  return inertial;
}

Shape to_shape(const urdf::Geometry& source, const std::filesystem::path& folder) {
  if (const auto* box = dynamic_cast<const urdf::Box*>(&source)) return Box{to_eigen(box->dim)};
  if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&source))
    return Cylinder{cylinder->radius, cylinder->length};
  if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&source)) return Sphere{sphere->radius};
  const auto& mesh = dynamic_cast<const urdf::Mesh&>(source);
  return Mesh{resolve_below(folder, mesh.filename, {}).value(), mesh.filename, to_eigen(mesh.scale)};
}

template <class Part>
Geometry to_geometry(const Part& source, const std::filesystem::path& folder) {
  Geometry geometry;
  geometry.name = source.name;
  geometry.X_LG = to_eigen(source.origin);
  geometry.shape = to_shape(*source.geometry, folder);
  return geometry;
}

Geometry to_visual(const urdf::Visual& source, const std::filesystem::path& folder) {
  Geometry geometry = to_geometry(source, folder);
  geometry.material = source.material_name;
  if (source.material != nullptr) {
    const urdf::Color& color = source.material->color;
    geometry.rgba = {color.r, color.g, color.b, color.a};
  }
  return geometry;
}

Link to_link(const urdf::Link& source, const std::filesystem::path& folder) {
  Link link{source.name, {}, {}, {}};
  if (source.inertial) link.inertial = to_inertial(*source.inertial);
  for (const auto& visual : source.visual_array) link.visuals.push_back(to_visual(*visual, folder));
  for (const auto& collision : source.collision_array) link.collisions.push_back(to_geometry(*collision, folder));
  return link;
}

JointType to_type(const urdf::Joint& source) {
  switch (source.type) {
    case urdf::Joint::REVOLUTE:
      return JointType::kRevolute;
    case urdf::Joint::CONTINUOUS:
      return JointType::kContinuous;
    case urdf::Joint::PRISMATIC:
      return JointType::kPrismatic;
    default:
      return JointType::kFixed;
  }
}

Joint to_joint(const urdf::Joint& source) {
  Joint joint;
  joint.name = source.name;
  joint.type = to_type(source);
  joint.parent = source.parent_link_name;
  joint.child = source.child_link_name;
  joint.X_PJ = to_eigen(source.parent_to_joint_origin_transform);
  if (joint.type == JointType::kFixed) return joint;
  joint.axis = to_eigen(source.axis).normalized();
  const bool bounded = joint.type != JointType::kContinuous && source.limits;
  joint.lower = bounded ? source.limits->lower : -kInfinity;
  joint.upper = bounded ? source.limits->upper : kInfinity;
  joint.velocity = source.limits ? source.limits->velocity : kInfinity;
  joint.effort = source.limits ? source.limits->effort : kInfinity;
  joint.damping = source.dynamics ? source.dynamics->damping : 0.0;
  joint.friction = source.dynamics ? source.dynamics->friction : 0.0;
  return joint;
}

/// Appends the links below `root` parents first; siblings in the order in which the file names their joints.
void append_tree(const urdf::ModelInterface& source, const std::vector<std::string>& joint_order,
                 const std::filesystem::path& folder, RobotModel& model) {
  std::map<std::string, std::vector<const urdf::Joint*>> children;
  for (const auto& name : joint_order) {
    const urdf::Joint* joint = source.getJoint(name).get();
    children[joint->parent_link_name].push_back(joint);
  }
  std::vector<const urdf::Joint*> open;
  const auto push_children = [&](const std::string& link) {
    const auto& below = children[link];
    open.insert(open.end(), below.rbegin(), below.rend());
  };
  model.links.push_back(to_link(*source.getRoot(), folder));
  push_children(source.getRoot()->name);
  while (!open.empty()) {
    const urdf::Joint* joint = open.back();
    open.pop_back();
    model.joints.push_back(to_joint(*joint));
    model.links.push_back(to_link(*source.getLink(joint->child_link_name), folder));
    push_children(joint->child_link_name);
  }
}

template <class Item>
const Item* find_by_name(const std::vector<Item>& items, std::string_view name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

}  // namespace

std::string_view to_string(JointType type) {
  switch (type) {
    case JointType::kFixed:
      return "fixed";
    case JointType::kRevolute:
      return "revolute";
    case JointType::kContinuous:
      return "continuous";
    case JointType::kPrismatic:
      return "prismatic";
  }
  return "fixed";
}

Result<RobotModel> RobotModel::load(const std::filesystem::path& urdf) {
  const auto with_file = [&](Diagnostics diagnostics) {
    diagnostics.set_file(urdf.string());
    return diagnostics;
  };
  const auto text = read_file(urdf, kMaxXmlBytes);
  if (!text) return std::unexpected(with_file(text.error()));
  const auto folder = urdf.has_parent_path() ? urdf.parent_path() : std::filesystem::path(".");
  auto model = parse(*text, folder);
  if (!model) return std::unexpected(with_file(std::move(model.error())));
  model->warnings.set_file(urdf.string());
  return model;
}

Result<RobotModel> RobotModel::parse(std::string_view xml, const std::filesystem::path& folder) {
  const auto tree = scan_xml(xml);
  if (!tree) return std::unexpected(tree.error());
  Diagnostics diagnostics = check_urdf(*tree, folder);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const auto source = parse_with_urdfdom(tree->sanitized, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));

  std::vector<std::string> joint_order;
  for (const XmlElement* joint : tree->children(tree->elements.front(), "joint"))
    joint_order.push_back(*joint->attribute("name"));
  RobotModel model;
  model.name = source->getName();
  model.warnings = std::move(diagnostics);
  append_tree(*source, joint_order, folder, model);
  return model;
}

const Link* RobotModel::link(std::string_view link_name) const { return find_by_name(links, link_name); }

const Joint* RobotModel::joint(std::string_view joint_name) const { return find_by_name(joints, joint_name); }

const Joint* RobotModel::joint_above(std::string_view link_name) const {
  const auto found = std::find_if(joints.begin(), joints.end(), [&](const Joint& j) { return j.child == link_name; });
  return found == joints.end() ? nullptr : &*found;
}

double RobotModel::total_mass() const {
  double mass = 0.0;
  for (const Link& link : links) mass += link.inertial ? link.inertial->mass : 0.0;
  return mass;
}

}  // namespace takt::kinematics
