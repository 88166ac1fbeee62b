#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/base/diagnostics.h"

namespace takt::kinematics {

/// Shapes, centred on their own frame G; all lengths in m. A cylinder's axis is z.
struct Box {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< full edge lengths
};
struct Cylinder {
  double radius = 0.0;
  double length = 0.0;
};
struct Sphere {
  double radius = 0.0;
};
struct Mesh {
  std::filesystem::path path;                       ///< resolved: an existing file below the folder of the URDF
  std::string name;                                 ///< as the URDF writes it, relative to its folder
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< no unit
};
using Shape = std::variant<Box, Cylinder, Sphere, Mesh>;

/// A shape fixed to link L.
struct Geometry {
  std::string name;  ///< may be empty
  Eigen::Isometry3d X_LG = Eigen::Isometry3d::Identity();
  Shape shape;
  std::string material;                                        ///< name; empty if there is none, and for collisions
  Eigen::Vector4d rgba = Eigen::Vector4d(0.7, 0.7, 0.7, 1.0);  ///< 0..1; light grey without a material
};

/// Mass of a link. C = the inertia frame: origin in the centre of mass.
struct Inertial {
  double mass = 0.0;                                       ///< kg, > 0
  Eigen::Isometry3d X_LC = Eigen::Isometry3d::Identity();  ///< C in link frame L
  Eigen::Matrix3d I_C = Eigen::Matrix3d::Zero();           ///< about the centre of mass, axes of C, kg m^2
};

struct Link {
  std::string name;
  std::optional<Inertial> inertial;  ///< none: a frame without mass
  std::vector<Geometry> visuals;
  std::vector<Geometry> collisions;
};

enum class JointType { kFixed, kRevolute, kContinuous, kPrismatic };

/// URDF's word for the type, e.g. "revolute".
[[nodiscard]] std::string_view to_string(JointType type);

/// Joins frame P of the parent link with frame C of the child: X_PC(q) = X_PJ * motion of q about or along `axis`.
struct Joint {
  std::string name;
  JointType type = JointType::kFixed;
  std::string parent;  ///< link name
  std::string child;   ///< link name
  Eigen::Isometry3d X_PJ = Eigen::Isometry3d::Identity();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< in J, unit length
  double lower = 0.0;                               ///< rad or m; -infinity for continuous; 0 for fixed
  double upper = 0.0;                               ///< rad or m; +infinity for continuous; 0 for fixed
  double velocity = 0.0;                            ///< rad/s or m/s, > 0; +infinity if the URDF gives none
  double effort = 0.0;                              ///< Nm or N, > 0; +infinity if the URDF gives none
  double damping = 0.0;                             ///< Nms/rad or Ns/m
  double friction = 0.0;                            ///< Coulomb, Nm or N
};

/// A robot as its URDF says: what kinematics, simulation and pictures are built from. Plain data without any type of
/// the parser; a checked tree, so that users need not check again. Thread: any, while nobody writes.
struct RobotModel {
  std::string name;
  /// In tree order: the root first, each parent before its children, siblings in the order of the file.
  std::vector<Link> links;
  /// joints[i] moves links[i + 1]: a tree has one joint less than links.
  std::vector<Joint> joints;
  /// What is not wrong but may not be meant, e.g. an unknown element.
  Diagnostics warnings;

  /// Reads a URDF file. @return the model, or everything found wrong in it, with line numbers: what parse() says, and
  /// a missing or unreadable file. Realtime: setup.
  [[nodiscard]] static Result<RobotModel> load(const std::filesystem::path& urdf);

  /// Parses URDF text. Mesh names are resolved below `folder` and may not leave it.
  /// Refused, all at once: malformed XML, more than 4 MiB, deeper than 64, a DOCTYPE, more than 1000 links; duplicate
  /// names, loops, two parents, several roots; unknown joint types, mimic joints, zero axes, absent or reversed limits;
  /// numbers that are none or not finite; impossible masses and inertias; missing meshes, undefined materials.
  /// Realtime: setup.
  [[nodiscard]] static Result<RobotModel> parse(std::string_view xml, const std::filesystem::path& folder);

  [[nodiscard]] const Link& root() const { return links.front(); }
  /// The link of that name, or null.
  [[nodiscard]] const Link* link(std::string_view link_name) const;
  /// The joint of that name, or null.
  [[nodiscard]] const Joint* joint(std::string_view joint_name) const;
  /// The joint that moves that link, or null for the root and for unknown names.
  [[nodiscard]] const Joint* joint_above(std::string_view link_name) const;
  /// Of all links, kg.
  [[nodiscard]] double total_mass() const;
};

}  // namespace takt::kinematics
