#include "tools/import/node.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "core/base/xml_text.h"

namespace takt::tools {
namespace {

std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> found;
  std::size_t begin = 0;
  constexpr std::string_view kBlank = " \t\r\n";
  while ((begin = text.find_first_not_of(kBlank, begin)) != std::string_view::npos) {
    const std::size_t end = std::min(text.find_first_of(kBlank, begin), text.size());
    found.emplace_back(text.substr(begin, end - begin));
    begin = end;
  }
  return found;
}

void write(const Node& node, int level, std::string& out) {
  const std::string indent(static_cast<std::size_t>(2 * level), ' ');
  out += fmt::format("{}<{}", indent, node.name);
  for (const auto& [key, value] : node.attributes) out += fmt::format(" {}=\"{}\"", key, xml_text(value));
  if (node.children.empty()) {
    out += "/>\n";
    return;
  }
  out += ">\n";
  for (const Node& child : node.children) write(child, level + 1, out);
  out += fmt::format("{}</{}>\n", indent, node.name);
}

}  // namespace

const std::string* Node::get(std::string_view key) const {
  for (const auto& [name_here, value] : attributes) {
    if (name_here == key) return &value;
  }
  return nullptr;
}

std::string Node::text(std::string_view key) const {
  const std::string* value = get(key);
  return value != nullptr ? *value : std::string();
}

std::optional<std::vector<double>> Node::numbers(std::string_view key, std::size_t count) const {
  const std::string* value = get(key);
  if (value == nullptr) return std::nullopt;
  std::vector<double> list;
  for (const std::string& word : words(*value)) {
    double number = 0.0;
    const char* begin = word.c_str() + (word.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(begin, word.c_str() + word.size(), number);
    if (error != std::errc{} || *end != '\0' || !std::isfinite(number)) return std::nullopt;
    list.push_back(number);
  }
  return list.size() == count ? std::optional(list) : std::nullopt;
}

std::optional<double> Node::number(std::string_view key) const {
  const auto list = numbers(key, 1);
  return list ? std::optional(list->front()) : std::nullopt;
}

Eigen::Vector3d Node::vector(std::string_view key, const Eigen::Vector3d& otherwise) const {
  const auto list = numbers(key, 3);
  return list ? Eigen::Vector3d(list->data()) : otherwise;
}

void Node::set(std::string_view key, std::string value) {
  for (auto& [name_here, old] : attributes) {
    if (name_here != key) continue;
    old = std::move(value);
    return;
  }
  attributes.emplace_back(key, std::move(value));
}

void Node::set(std::string_view key, double value) { set(key, fmt::format("{:.10g}", value)); }

void Node::set(std::string_view key, const Eigen::Vector3d& value) {
  set(key, fmt::format("{:.10g} {:.10g} {:.10g}", value.x(), value.y(), value.z()));
}

void Node::drop(std::string_view key) {
  std::erase_if(attributes, [&](const auto& attribute) { return attribute.first == key; });
}

Node* Node::child(std::string_view child_name) {
  const auto found = std::ranges::find(children, child_name, &Node::name);
  return found == children.end() ? nullptr : &*found;
}

const Node* Node::child(std::string_view child_name) const { return const_cast<Node*>(this)->child(child_name); }

Node& Node::need(std::string_view child_name) {
  Node* found = child(child_name);
  return found != nullptr ? *found : add(child_name);
}

Node& Node::add(std::string_view child_name) {
  children.push_back({std::string(child_name), {}, {}});
  return children.back();
}

void Node::drop_children(std::string_view child_name) {
  std::erase_if(children, [&](const Node& node) { return node.name == child_name; });
}

std::vector<Node*> Node::all(std::string_view child_name) {
  std::vector<Node*> found;
  for (Node& node : children) {
    if (node.name == child_name) found.push_back(&node);
  }
  return found;
}

Eigen::Isometry3d Node::origin() const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const Node* node = child("origin");
  if (node == nullptr) return X;
  const Eigen::Vector3d rpy = node->vector("rpy", Eigen::Vector3d::Zero());
  X.translation() = node->vector("xyz", Eigen::Vector3d::Zero());
  X.linear() =
      (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return X;
}

void Node::set_origin(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
  Node& node = need("origin");
  node.set("xyz", xyz);
  node.set("rpy", rpy);
}

Eigen::Vector3d rpy_of(const Eigen::Matrix3d& R) {
  const double yaw = std::atan2(R(1, 0), R(0, 0)), c = std::cos(yaw), s = std::sin(yaw);
  // What is left once the yaw is taken off: where the pitch is a quarter turn, any yaw has a roll that fits it.
  const double pitch = std::atan2(-R(2, 0), c * R(0, 0) + s * R(1, 0));
  const double roll = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));
  return {roll, pitch, yaw};
}

Node node_of(const kinematics::XmlTree& tree, int index) {
  const kinematics::XmlElement& element = tree.elements[static_cast<std::size_t>(index)];
  Node node{element.name, element.attributes, {}};
  for (const int child : element.children) node.children.push_back(node_of(tree, child));
  return node;
}

std::string xml_of(const Node& node) {
  std::string out = "<?xml version=\"1.0\"?>\n";
  write(node, 0, out);
  return out;
}

}  // namespace takt::tools
