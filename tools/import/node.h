#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/kinematics/xml_scan.h"

namespace takt::tools {

/// An XML element that may be changed. Realtime: setup, all of this folder.
struct Node {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<Node> children;

  /// The attribute, or null.
  [[nodiscard]] const std::string* get(std::string_view key) const;
  /// The attribute, or an empty text.
  [[nodiscard]] std::string text(std::string_view key) const;
  /// Its numbers; nothing if it is absent, holds something else or not `count` of them.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key, std::size_t count) const;
  [[nodiscard]] std::optional<double> number(std::string_view key) const;
  [[nodiscard]] Eigen::Vector3d vector(std::string_view key, const Eigen::Vector3d& otherwise) const;

  void set(std::string_view key, std::string value);
  void set(std::string_view key, double value);
  void set(std::string_view key, const Eigen::Vector3d& value);
  void drop(std::string_view key);

  /// The first child of that name, or null.
  [[nodiscard]] Node* child(std::string_view child_name);
  [[nodiscard]] const Node* child(std::string_view child_name) const;
  /// The first child of that name; it is made if there is none.
  Node& need(std::string_view child_name);
  Node& add(std::string_view child_name);
  void drop_children(std::string_view child_name);
  [[nodiscard]] std::vector<Node*> all(std::string_view child_name);

  /// X of an <origin> in it, the identity without one.
  [[nodiscard]] Eigen::Isometry3d origin() const;
  void set_origin(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy);
};

/// Roll, pitch and yaw of a rotation, as a URDF has them: exact at a pitch of a quarter turn, too.
[[nodiscard]] Eigen::Vector3d rpy_of(const Eigen::Matrix3d& R);

/// The tree below tree.elements[index]: at most kMaxXmlDepth deep, as the scan has seen to.
[[nodiscard]] Node node_of(const kinematics::XmlTree& tree, int index = 0);
/// XML text with two spaces a level.
[[nodiscard]] std::string xml_of(const Node& node);

}  // namespace takt::tools
