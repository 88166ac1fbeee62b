// First steps: plain words, plain names, plain colours.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "core/kinematics/urdf_words.h"
#include "tools/import/draft.h"

namespace takt::tools {
namespace {

using kinematics::urdf_word;

/// Elements and attributes that no URDF reader of ours knows, with how often.
void drop_foreign(Node& node, std::map<std::string, int>& dropped) {
  const auto* word = urdf_word(node.name);
  if (word == nullptr) return;
  std::erase_if(node.attributes, [&](const auto& attribute) {
    const bool keep = word->attributes.contains(attribute.first);
    if (!keep && !attribute.first.starts_with("xmlns")) ++dropped[fmt::format("{} of {}", attribute.first, node.name)];
    return !keep;
  });
  std::erase_if(node.children, [&](const Node& child) {
    const auto* known = urdf_word(child.name);
    // Couplings are not foreign: they are judged with the joints.
    const bool keep =
        child.name == "mimic" || (word->children.contains(child.name) && known != nullptr && !known->foreign);
    if (!keep) ++dropped[child.name];
    return !keep;
  });
  for (Node& child : node.children) drop_foreign(child, dropped);
}

/// Of URDF 1.1: the orientation of an origin as a quaternion x, y, z, w.
int plain_quaternions(Node& node) {
  int count = 0;
  if (node.name == "origin" && node.get("quat_xyzw") != nullptr) {
    const auto q = node.numbers("quat_xyzw", 4);
    const Eigen::Quaterniond turn = q ? Eigen::Quaterniond(q->data()) : Eigen::Quaterniond(0, 0, 0, 0);
    if (turn.norm() > 1e-6) {
      node.set("rpy", rpy_of(turn.normalized().toRotationMatrix()));
      node.drop("quat_xyzw");
      ++count;
    }
  }
  for (Node& child : node.children) count += plain_quaternions(child);
  return count;
}

/// Of URDF 1.2: a cylinder with round ends becomes one that reaches as far.
int plain_capsules(Node& node) {
  int count = 0;
  if (node.name == "capsule" && node.number("radius") && node.number("length")) {
    node.name = "cylinder";
    node.set("length", *node.number("length") + 2.0 * *node.number("radius"));
    ++count;
  }
  for (Node& child : node.children) count += plain_capsules(child);
  return count;
}

/// Our reader knows URDF 1.0: what later versions write in other words is written in its words.
void plain_version(Draft& draft) {
  const std::string version = draft.robot.text("version");
  draft.robot.drop("version");
  if (version.empty() || version == "1" || version == "1.0") return;
  draft.note("URDF", fmt::format("version {}", version), "read as far as 1.0 has words for it");
  if (const int count = plain_quaternions(draft.robot); count > 0)
    draft.note("orientations", fmt::format("{} quaternions", count), "as roll, pitch and yaw");
  if (const int count = plain_capsules(draft.robot); count > 0)
    draft.note("capsules", fmt::format("{} cylinders", count), "that reach as far");
}

/// "Joint-A1 left" becomes "joint_a1_left"; used names get a number.
std::string plain(const std::string& name, std::set<std::string>& used) {
  std::string out;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    out += std::isalnum(u) != 0 ? static_cast<char>(std::tolower(u)) : '_';
  }
  if (out.empty() || std::isalpha(static_cast<unsigned char>(out.front())) == 0) out = "n_" + out;
  std::string unique = out;
  for (int k = 2; !used.insert(unique).second; ++k) unique = fmt::format("{}_{}", out, k);
  return unique;
}

/// Two parts of one name are an error of the file that the checker shall see: they get one new name.
std::map<std::string, std::string> plain_names(std::vector<Node*> nodes) {
  std::map<std::string, std::string> renamed;
  std::set<std::string> used;
  for (Node* node : nodes) {
    const std::string* name = node->get("name");
    if (name == nullptr || name->empty()) continue;
    if (!renamed.contains(*name)) renamed[*name] = plain(*name, used);
    node->set("name", renamed[*name]);
  }
  return renamed;
}

void rename(Draft& draft) {
  const auto joints = plain_names(draft.robot.all("joint"));
  const auto links = plain_names(draft.robot.all("link"));
  int changed = 0;
  for (const auto* names : {&joints, &links}) {
    changed += static_cast<int>(std::ranges::count_if(*names, [](const auto& n) { return n.first != n.second; }));
  }
  for (Node* joint : draft.robot.all("joint")) {
    for (const char* side : {"parent", "child"}) {
      Node* end = joint->child(side);
      const auto found = end != nullptr ? links.find(end->text("link")) : links.end();
      if (found != links.end()) end->set("link", found->second);
    }
    Node* mimic = joint->child("mimic");
    if (mimic != nullptr && joints.contains(mimic->text("joint"))) mimic->set("joint", joints.at(mimic->text("joint")));
  }
  if (changed > 0) draft.note("names", fmt::format("{} changed", changed), "lower case letters, digits and _ only");
  std::map<std::string, JointExtras> extras;
  for (auto& [joint, figures] : draft.extras) extras[joints.contains(joint) ? joints.at(joint) : joint] = figures;
  draft.extras = std::move(extras);
  std::vector<std::string*> wanted{&draft.base, &draft.flange};
  for (std::string& link : draft.without) wanted.push_back(&link);
  for (std::string* link : wanted)
    if (const auto found = links.find(*link); found != links.end()) *link = found->second;
}

constexpr const char* kGrey = "0.7 0.7 0.72 1";

std::string colour_of(const Node& material, const std::map<std::string, std::string>& known) {
  const Node* colour = material.child("color");
  if (colour != nullptr) {
    if (const auto rgba = colour->numbers("rgba", 4)) {
      std::string text;
      for (const double part : *rgba)
        text += fmt::format("{}{:g}", text.empty() ? "" : " ", std::clamp(part, 0.0, 1.0));
      return text;
    }
  }
  const auto found = known.find(material.text("name"));
  return found == known.end() ? kGrey : found->second;
}

/// Each colour becomes one material of the robot; files define them twice, nowhere, or without a name.
void plain_materials(Draft& draft) {
  std::map<std::string, std::string> known, names;
  std::vector<Node> materials;
  const auto visuals = [&](auto&& each) {
    for (Node* link : draft.robot.all("link")) {
      for (Node* visual : link->all("visual")) {
        if (Node* material = visual->child("material")) each(*material);
      }
    }
  };
  for (Node* material : draft.robot.all("material")) known[material->text("name")] = colour_of(*material, known);
  visuals([&](Node& material) { known.emplace(material.text("name"), colour_of(material, known)); });
  visuals([&](Node& material) {
    const std::string rgba = colour_of(material, known);
    const auto [entry, added] = names.emplace(rgba, fmt::format("colour_{}", names.size() + 1));
    if (added) {
      Node definition{"material", {{"name", entry->second}}, {}};
      definition.add("color").set("rgba", rgba);
      materials.push_back(definition);
    }
    material = {"material", {{"name", entry->second}}, {}};
  });
  draft.robot.drop_children("material");
  draft.robot.children.insert(draft.robot.children.begin(), materials.begin(), materials.end());
}

}  // namespace

Node* Draft::link(std::string_view name) {
  for (Node* node : robot.all("link")) {
    if (node->text("name") == name) return node;
  }
  return nullptr;
}

Node* Draft::joint_above(std::string_view link_name) {
  for (Node* joint : robot.all("joint")) {
    if (child_of(*joint) == link_name) return joint;
  }
  return nullptr;
}

std::vector<Node*> Draft::joints_below(std::string_view link_name) {
  std::vector<Node*> found = robot.all("joint");
  std::erase_if(found, [&](const Node* joint) { return parent_of(*joint) != link_name; });
  return found;
}

std::string parent_of(const Node& joint) {
  const Node* end = joint.child("parent");
  return end != nullptr ? end->text("link") : std::string();
}

std::string child_of(const Node& joint) {
  const Node* end = joint.child("child");
  return end != nullptr ? end->text("link") : std::string();
}

bool is_movable(const Node& joint) {
  const std::string type = joint.text("type");
  return type == "revolute" || type == "continuous" || type == "prismatic";
}

void clean(Draft& draft, const std::string& name) {
  std::map<std::string, int> dropped;
  plain_version(draft);
  drop_foreign(draft.robot, dropped);
  std::string list;
  for (const auto& [word, count] : dropped) {
    const bool attribute = word.find(' ') != word.npos;
    list +=
        fmt::format("{}{} {}{}{}", list.empty() ? "" : ", ", count, attribute ? "" : "<", word, attribute ? "" : ">");
  }
  if (!list.empty()) draft.note("left out", list, "nothing here reads them");
  draft.robot.set("name", name);
  rename(draft);
  plain_materials(draft);
}

}  // namespace takt::tools
