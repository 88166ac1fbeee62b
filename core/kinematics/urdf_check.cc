#include "core/kinematics/urdf_check.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "core/base/json.h"
#include "core/kinematics/urdf_words.h"

namespace takt::kinematics {
namespace {

std::string place(const XmlElement& element) { return fmt::format("line {}", element.line); }

std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> words;
  std::string word;
  for (const char c : text) {
    const bool space = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!space) word += c;
    if (space && !word.empty()) words.push_back(std::exchange(word, {}));
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

/// What larger numbers mean is a slip of the unit or of the pen.
constexpr double kLargest = 1e9;

/// Of one mesh file: 200 000 triangles of a binary STL, as many as MuJoCo takes; no picture gets better by more.
constexpr std::uintmax_t kMaxMeshBytes = 10'000'084;

class Checker {
 public:
  Checker(const XmlTree& tree, const std::filesystem::path& folder) : tree_(tree), folder_(folder) {}

  Diagnostics run() {
    const XmlElement& robot = tree_.elements.front();
    if (robot.name != "robot") {
      diagnostics_.error(Code::kSyntax, place(robot), fmt::format("the root element is <{}>", robot.name),
                         "Begin with <robot>");
      return std::move(diagnostics_);
    }
    if (Diagnostics xacro = check_no_xacro(tree_); xacro.has_errors()) return xacro;
    check_words(robot);
    name_of(robot, "the robot");
    for (const XmlElement* material : tree_.children(robot, "material")) check_material(*material, true);
    const auto links = tree_.children(robot, "link");
    const auto joints = tree_.children(robot, "joint");
    if (links.empty()) diagnostics_.error(Code::kMissing, place(robot), "the robot has no link");
    if (links.size() > kMaxLinks)
      diagnostics_.error(Code::kTooLarge, place(robot), fmt::format("{} links", links.size()),
                         fmt::format("Keep it to at most {}", kMaxLinks));
    for (const XmlElement* link : links) check_link(*link);
    for (const XmlElement* joint : joints) check_joint(*joint);
    check_tree(robot);
    check_material_uses();
    return std::move(diagnostics_);
  }

 private:
  // --- words -----------------------------------------------------------------------------------------------------

  /// Unknown elements and attributes are ignored by every URDF reader, but they may be typing errors.
  void check_words(const XmlElement& element) {
    const UrdfWord* word = urdf_word(element.name);
    if (word == nullptr || word->foreign) return;
    for (const auto& [key, value] : element.attributes) {
      if (!word->attributes.contains(key)) warn_unknown(element, "attribute", key, word->attributes);
    }
    for (const int index : element.children) {
      const XmlElement& child = tree_.elements[static_cast<std::size_t>(index)];
      if (!word->children.contains(child.name)) warn_unknown(child, "element", child.name, word->children);
    }
  }

  void warn_unknown(const XmlElement& element, std::string_view kind, const std::string& name,
                    const std::set<std::string>& known) {
    diagnostics_.warning(Code::kUnsupported, place(element), fmt::format("unknown {} '{}' is ignored", kind, name),
                         nearest_choice(name, {known.begin(), known.end()}));
  }

  // --- attributes ------------------------------------------------------------------------------------------------

  /// The name attribute; a missing one is an error.
  std::string name_of(const XmlElement& element, std::string_view what) {
    const std::string* name = element.attribute("name");
    if (name == nullptr || name->empty()) {
      diagnostics_.error(Code::kMissing, place(element), fmt::format("{} has no name", what), "Add name=\"...\"");
      return {};
    }
    return *name;
  }

  std::optional<double> number(const XmlElement& element, const std::string& key, const std::string& word) {
    double value = 0.0;
    const char* begin = word.c_str() + (word.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(begin, word.c_str() + word.size(), value);
    const std::string text = fmt::format("{}: {} of <{}> is '{:.40}'", who_, key, element.name, word);
    if (error == std::errc::invalid_argument || *end != '\0') {
      diagnostics_.error(Code::kSyntax, place(element), text, "Give a number");
    } else if (error == std::errc::result_out_of_range || !std::isfinite(value)) {
      diagnostics_.error(Code::kSyntax, place(element), text, "Give a finite number");
    } else if (std::abs(value) > kLargest) {
      diagnostics_.error(Code::kOutOfRange, place(element), text,
                         fmt::format("Give a number of at most {:g}", kLargest));
    } else {
      return value;
    }
    return std::nullopt;
  }

  /// The `count` numbers of an attribute; nothing if it is absent or wrong (which is a diagnostic).
  std::optional<std::vector<double>> numbers(const XmlElement& element, const std::string& key, std::size_t count,
                                             bool required) {
    const std::string* text = element.attribute(key);
    if (text == nullptr) {
      if (required)
        diagnostics_.error(Code::kMissing, place(element), fmt::format("{}: <{}> has no {}", who_, element.name, key));
      return std::nullopt;
    }
    const auto words = split(*text);
    if (words.size() != count) {
      diagnostics_.error(Code::kWrongSize, place(element),
                         fmt::format("{}: {} of <{}> has {} numbers", who_, key, element.name, words.size()),
                         fmt::format("{}", count));
      return std::nullopt;
    }
    std::vector<double> values;
    for (const auto& word : words) {
      if (const auto value = number(element, key, word)) values.push_back(*value);
    }
    return values.size() == count ? std::optional(values) : std::nullopt;
  }

  std::optional<double> scalar(const XmlElement& element, const std::string& key, bool required) {
    const auto values = numbers(element, key, 1, required);
    return values ? std::optional(values->front()) : std::nullopt;
  }

  void positive(const XmlElement& element, const std::string& key, std::string_view unit) {
    const auto value = scalar(element, key, true);
    if (value && *value <= 0.0) out_of_range(element, key, *value, unit, "> 0");
  }

  void out_of_range(const XmlElement& element, const std::string& key, double value, std::string_view unit,
                    std::string_view allowed) {
    diagnostics_.error(Code::kOutOfRange, place(element),
                       fmt::format("{}: {} of <{}> is {:g} {}", who_, key, element.name, value, unit),
                       std::string(allowed));
  }

  /// The only child of that name; a second one is an error, an absent one if it is required.
  const XmlElement* only_child(const XmlElement& element, std::string_view name, bool required) {
    const auto found = tree_.children(element, name);
    if (found.empty() && required)
      diagnostics_.error(Code::kMissing, place(element), fmt::format("{}: <{}> has no <{}>", who_, element.name, name));
    if (found.size() > 1)
      diagnostics_.error(Code::kDuplicate, place(*found[1]), fmt::format("{}: a second <{}>", who_, name));
    if (!found.empty()) check_words(*found.front());
    return found.empty() ? nullptr : found.front();
  }

  void check_origin(const XmlElement& element) {
    if (const XmlElement* origin = only_child(element, "origin", false)) {
      numbers(*origin, "xyz", 3, false);
      numbers(*origin, "rpy", 3, false);
    }
  }

  // --- links -----------------------------------------------------------------------------------------------------

  void check_link(const XmlElement& link) {
    check_words(link);
    const std::string name = name_of(link, "a link");
    who_ = fmt::format("link '{}'", name);
    if (!name.empty() && !link_names_.emplace(name, &link).second)
      diagnostics_.error(Code::kDuplicate, place(link), fmt::format("a second link '{}'", name),
                         "Give each a name of its own");
    if (const XmlElement* inertial = only_child(link, "inertial", false)) check_inertial(*inertial);
    for (const XmlElement* visual : tree_.children(link, "visual")) check_geometry(*visual);
    for (const XmlElement* collision : tree_.children(link, "collision")) check_geometry(*collision);
  }

  void check_inertial(const XmlElement& inertial) {
    check_origin(inertial);
    if (const XmlElement* mass = only_child(inertial, "mass", true)) {
      const auto value = scalar(*mass, "value", true);
      if (value && *value <= 0.0)
        out_of_range(*mass, "value", *value, "kg", "> 0; leave <inertial> out for a link without mass");
    }
    if (const XmlElement* inertia = only_child(inertial, "inertia", true)) check_inertia(*inertia);
  }

  void check_inertia(const XmlElement& inertia) {
    std::array<double, 6> i{};
    bool whole = true;
    for (std::size_t k = 0; k < i.size(); ++k) {
      constexpr std::array kKeys = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};
      const auto value = scalar(inertia, kKeys[k], true);
      whole = whole && value.has_value();
      i[k] = value.value_or(0.0);
    }
    if (!whole) return;
    Eigen::Matrix3d tensor;
    tensor << i[0], i[1], i[2], i[1], i[3], i[4], i[2], i[4], i[5];
    const Eigen::Vector3d moments =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor, Eigen::EigenvaluesOnly).eigenvalues();
    const std::string text = fmt::format("{}: the principal moments are {:.4g}, {:.4g}, {:.4g} kg m^2", who_,
                                         moments[0], moments[1], moments[2]);
    if (moments[0] <= 0.0) {
      diagnostics_.error(Code::kInvalidValue, place(inertia), text,
                         "Make all of them > 0: the tensor must be positive definite");
    } else if (moments[0] + moments[1] < moments[2] * (1.0 - 1e-9)) {
      diagnostics_.error(Code::kInvalidValue, place(inertia), text,
                         "Keep each moment below the sum of the other two (triangle rule)");
    }
  }

  void check_geometry(const XmlElement& part) {
    check_words(part);
    check_origin(part);
    if (const XmlElement* material = only_child(part, "material", false)) check_material(*material, false);
    const XmlElement* geometry = only_child(part, "geometry", true);
    if (geometry == nullptr) return;
    if (geometry->children.size() != 1) {
      diagnostics_.error(Code::kWrongSize, place(*geometry),
                         fmt::format("{}: <geometry> holds {} shapes", who_, geometry->children.size()),
                         "Use one of box, cylinder, sphere, mesh");
      return;
    }
    check_shape(tree_.elements[static_cast<std::size_t>(geometry->children.front())]);
  }

  void check_shape(const XmlElement& shape) {
    check_words(shape);
    if (shape.name == "box") {
      const auto size = numbers(shape, "size", 3, true);
      for (const double edge : size.value_or(std::vector<double>{})) {
        if (edge <= 0.0) out_of_range(shape, "size", edge, "m", "all > 0");
      }
    } else if (shape.name == "sphere") {
      positive(shape, "radius", "m");
    } else if (shape.name == "cylinder") {
      positive(shape, "radius", "m");
      positive(shape, "length", "m");
    } else if (shape.name == "mesh") {
      check_mesh(shape);
    } else {
      diagnostics_.error(Code::kInvalidValue, place(shape), fmt::format("{}: unknown shape <{}>", who_, shape.name),
                         nearest_choice(shape.name, {"box", "cylinder", "sphere", "mesh"}));
    }
  }

  void check_mesh(const XmlElement& mesh) {
    const auto scale = numbers(mesh, "scale", 3, false);
    for (const double factor : scale.value_or(std::vector<double>{})) {
      if (factor == 0.0) out_of_range(mesh, "scale", factor, "", "not zero");
    }
    const std::string* name = mesh.attribute("filename");
    const std::string hint = "Give a path relative to the folder of the URDF";
    if (name == nullptr || name->empty()) {
      diagnostics_.error(Code::kMissing, place(mesh), fmt::format("{}: <mesh> has no filename", who_), hint);
    } else if (name->find("://") != std::string::npos) {
      diagnostics_.error(Code::kInvalidValue, place(mesh),
                         fmt::format("{}: mesh '{}' is a URI; package:// and the like are not resolved", who_, *name),
                         hint);
    } else if (const auto path = resolve_below(folder_, *name, place(mesh)); !path) {
      diagnostics_.append(path.error());
    } else if (std::error_code error; !std::filesystem::is_regular_file(*path, error)) {
      diagnostics_.error(Code::kNotFound, place(mesh), fmt::format("{}: there is no mesh file '{}'", who_, *name),
                         hint);
    } else {
      check_mesh_file(mesh, *path, *name);
    }
  }

  void check_mesh_file(const XmlElement& mesh, const std::filesystem::path& path, const std::string& name) {
    std::string kind = path.extension().string();
    std::ranges::transform(kind, kind.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (kind != ".stl" && kind != ".obj") {
      diagnostics_.error(Code::kUnsupported, place(mesh),
                         fmt::format("{}: mesh '{}' is of a kind that is not read", who_, name),
                         "Convert it to .stl or .obj (MeshLab, Blender); 'takt new robot' makes a model without it");
      return;
    }
    std::error_code error;
    const auto bytes = std::filesystem::file_size(path, error);
    if (error || bytes <= kMaxMeshBytes) return;
    diagnostics_.error(
        Code::kTooLarge, place(mesh), fmt::format("{}: mesh '{}' has {} bytes", who_, name, bytes),
        fmt::format("Simplify it to at most {}, which is about {} triangles", kMaxMeshBytes, kMaxMeshBytes / 50));
  }

  // --- materials: defined by the robot or by their first use with a colour ---------------------------------------

  void check_material(const XmlElement& material, bool of_robot) {
    if (of_robot) who_ = "the robot";
    check_words(material);
    const std::string name = name_of(material, fmt::format("{}: a material", who_));
    const XmlElement* color = only_child(material, "color", false);
    if (const XmlElement* texture = only_child(material, "texture", false))
      diagnostics_.warning(Code::kUnsupported, place(*texture), fmt::format("{}: textures are not shown", who_),
                           "Give the material a colour");
    if (color == nullptr) {
      if (of_robot)
        diagnostics_.error(Code::kMissing, place(material), fmt::format("material '{}' has no <color>", name),
                           "Add rgba=\"r g b a\"");
      material_uses_.emplace_back(&material, name);
      return;
    }
    const auto rgba = numbers(*color, "rgba", 4, true);
    for (const double part : rgba.value_or(std::vector<double>{})) {
      if (part < 0.0 || part > 1.0) out_of_range(*color, "rgba", part, "", "0 to 1");
    }
    const auto [known, added] = materials_.emplace(name, rgba.value_or(std::vector<double>{}));
    if (!added && (of_robot || (rgba && known->second != *rgba)))
      diagnostics_.error(Code::kDuplicate, place(material), fmt::format("a second definition of material '{}'", name),
                         "Define it once, and refer to it by name");
  }

  void check_material_uses() {
    std::vector<std::string> known;
    for (const auto& entry : materials_) known.push_back(entry.first);
    for (const auto& [element, name] : material_uses_) {
      if (!materials_.contains(name))
        diagnostics_.error(Code::kUnknownName, place(*element), fmt::format("material '{}' is not defined", name),
                           nearest_choice(name, known));
    }
  }

  // --- joints ----------------------------------------------------------------------------------------------------

  void check_joint(const XmlElement& joint) {
    check_words(joint);
    const std::string name = name_of(joint, "a joint");
    who_ = fmt::format("joint '{}'", name);
    if (!name.empty() && !joint_names_.insert(name).second)
      diagnostics_.error(Code::kDuplicate, place(joint), fmt::format("a second joint '{}'", name),
                         "Give each a name of its own");
    check_origin(joint);
    if (const auto mimics = tree_.children(joint, "mimic"); !mimics.empty())
      diagnostics_.error(Code::kUnsupported, place(*mimics.front()),
                         fmt::format("{}: mimic joints are not supported", who_),
                         "Model the coupling in the device, or fix the joint");
    const std::string* type = joint.attribute("type");
    if (type == nullptr) {
      diagnostics_.error(Code::kMissing, place(joint), fmt::format("{} has no type", who_),
                         "Give it a type: revolute, continuous, prismatic or fixed");
    } else if (*type == "revolute" || *type == "prismatic" || *type == "continuous") {
      check_movable(joint, *type);
    } else if (*type != "fixed") {
      diagnostics_.error(Code::kUnsupported, place(joint), fmt::format("{}: type '{}' is not supported", who_, *type),
                         nearest_choice(*type, {"revolute", "continuous", "prismatic", "fixed"}));
    }
  }

  void check_movable(const XmlElement& joint, const std::string& type) {
    if (const XmlElement* axis = only_child(joint, "axis", false)) {
      if (const auto xyz = numbers(*axis, "xyz", 3, true)) check_axis(*axis, *xyz);
    }
    const XmlElement* limit = only_child(joint, "limit", false);
    if (limit != nullptr) {
      check_limit(*limit, type);
    } else if (type != "continuous") {
      diagnostics_.error(Code::kMissing, place(joint), fmt::format("{} ({}) has no <limit>", who_, type),
                         "Give lower, upper, velocity and effort");
    }
    if (const XmlElement* dynamics = only_child(joint, "dynamics", false)) {
      for (const char* key : {"damping", "friction"}) {
        const auto value = scalar(*dynamics, key, false);
        if (value && *value < 0.0) out_of_range(*dynamics, key, *value, "", ">= 0");
      }
    }
  }

  void check_axis(const XmlElement& axis, const std::vector<double>& xyz) {
    const double length = Eigen::Vector3d(xyz[0], xyz[1], xyz[2]).norm();
    if (length < 1e-6) {
      diagnostics_.error(Code::kOutOfRange, place(axis), fmt::format("{}: the axis is zero", who_), "Give a direction");
    } else if (std::abs(length - 1.0) > 1e-3) {
      diagnostics_.warning(Code::kInvalidValue, place(axis), fmt::format("{}: the axis has length {:g}", who_, length),
                           "Give an axis of length 1: this one is normalised");
    }
  }

  void check_limit(const XmlElement& limit, const std::string& type) {
    const bool bounded = type != "continuous";
    positive(limit, "velocity", type == "prismatic" ? "m/s" : "rad/s");
    positive(limit, "effort", type == "prismatic" ? "N" : "Nm");
    const auto lower = scalar(limit, "lower", bounded);
    const auto upper = scalar(limit, "upper", bounded);
    if (bounded && lower && upper && *lower >= *upper)
      diagnostics_.error(Code::kOutOfRange, place(limit),
                         fmt::format("{}: lower {:g} is not below upper {:g}", who_, *lower, *upper),
                         "Keep lower < upper, or use type fixed for a joint that never moves");
  }

  // --- the tree --------------------------------------------------------------------------------------------------

  /// The link that <parent> or <child> of a joint names; empty if it names none (a diagnostic).
  std::string end_of(const XmlElement& joint, const char* side) {
    const XmlElement* end = only_child(joint, side, true);
    if (end == nullptr) return {};
    const std::string* link = end->attribute("link");
    if (link != nullptr && link_names_.contains(*link)) return *link;
    std::vector<std::string> known;
    for (const auto& entry : link_names_) known.push_back(entry.first);
    diagnostics_.error(Code::kUnknownName, place(*end),
                       fmt::format("{}: {} link '{}' does not exist", who_, side, link ? *link : ""),
                       nearest_choice(link ? *link : "", known));
    return {};
  }

  void check_tree(const XmlElement& robot) {
    std::map<std::string, std::string> parent_of;
    bool whole = true;
    for (const XmlElement* joint : tree_.children(robot, "joint")) {
      const std::string* name = joint->attribute("name");
      who_ = fmt::format("joint '{}'", name ? *name : "");
      const std::string parent = end_of(*joint, "parent");
      const std::string child = end_of(*joint, "child");
      whole = whole && !parent.empty() && !child.empty();
      if (child.empty()) continue;
      if (!parent_of.emplace(child, parent).second)
        diagnostics_.error(Code::kDuplicate, place(*joint),
                           fmt::format("{}: link '{}' has a second parent", who_, child),
                           "Remove one of them: a robot is a tree, and each link has one joint above it");
    }
    check_loops(parent_of);
    if (whole) check_roots(robot, parent_of);
  }

  void check_loops(const std::map<std::string, std::string>& parent_of) {
    std::set<std::string> done;
    for (const auto& [start, ignored] : parent_of) {
      std::vector<std::string> path;
      std::set<std::string> on_path;
      std::string link = start;
      while (!link.empty() && !done.contains(link) && on_path.insert(link).second) {
        path.push_back(link);
        const auto up = parent_of.find(link);
        link = up == parent_of.end() ? std::string() : up->second;
      }
      if (on_path.contains(link)) report_loop(path, link);
      done.insert(path.begin(), path.end());
    }
  }

  void report_loop(const std::vector<std::string>& path, const std::string& entry) {
    std::string text = "'" + entry + "'";
    bool inside = false;
    for (const auto& link : path) {
      if (inside) text += " <- '" + link + "'";
      inside = inside || link == entry;
    }
    diagnostics_.error(Code::kInvalidValue, place(*link_names_.at(entry)),
                       fmt::format("the joints form a loop: {} <- '{}'", text, entry),
                       "Break the loop: a robot is a tree");
  }

  void check_roots(const XmlElement& robot, const std::map<std::string, std::string>& parent_of) {
    std::vector<std::string> roots;
    for (const XmlElement* link : tree_.children(robot, "link")) {
      const std::string* name = link->attribute("name");
      if (name && !parent_of.contains(*name) && std::find(roots.begin(), roots.end(), *name) == roots.end())
        roots.push_back(*name);
    }
    if (roots.size() < 2) return;
    std::string names;
    for (const auto& root : roots) names += (names.empty() ? "'" : ", '") + root + "'";
    diagnostics_.error(Code::kInvalidValue, place(robot),
                       fmt::format("{} links have no parent: {}", roots.size(), names),
                       "Keep one root, and join the others to it with joints");
  }

  const XmlTree& tree_;
  const std::filesystem::path& folder_;
  Diagnostics diagnostics_;
  std::string who_;  ///< the link or joint under check, for the messages
  std::map<std::string, const XmlElement*> link_names_;
  std::set<std::string> joint_names_;
  std::map<std::string, std::vector<double>> materials_;
  std::vector<std::pair<const XmlElement*, std::string>> material_uses_;
};

}  // namespace

Diagnostics check_no_xacro(const XmlTree& tree) {
  Diagnostics diagnostics;
  for (const XmlElement& element : tree.elements) {
    if (!element.name.starts_with("xacro:")) continue;
    diagnostics.error(Code::kSyntax, place(element),
                      fmt::format("<{}>: this is a xacro file, not a URDF", element.name),
                      "Expand it first, where ROS is installed: xacro FILE.urdf.xacro > FILE.urdf");
    break;
  }
  return diagnostics;
}

Diagnostics check_urdf(const XmlTree& tree, const std::filesystem::path& folder) { return Checker(tree, folder).run(); }

}  // namespace takt::kinematics
