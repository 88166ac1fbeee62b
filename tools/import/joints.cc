// Joints: couplings, limits; the chain from base to flange.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <set>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "tools/import/draft.h"

namespace takt::tools {
namespace {

/// What a limit becomes where a file has none: slow and within one turn, so that nothing surprises.
struct LimitDefault {
  const char* key;
  double turning, sliding;  ///< rad, rad/s, Nm; m, m/s, N
  const char *turning_unit, *sliding_unit;
};
constexpr std::array<LimitDefault, 4> kLimits = {{{"lower", -std::numbers::pi, -0.25, "rad", "m"},
                                                  {"upper", std::numbers::pi, 0.25, "rad", "m"},
                                                  {"velocity", 1.0, 0.1, "rad/s", "m/s"},
                                                  {"effort", 100.0, 500.0, "Nm", "N"}}};

constexpr std::size_t kMostJoints = 1000;

void freeze(Node& joint) {
  joint.set("type", std::string("fixed"));
  for (const char* word : {"axis", "limit", "mimic", "dynamics"}) joint.drop_children(word);
}

/// A value that is there and is a number, but not one that a limit can be.
bool unusable(const LimitDefault& limit, double value) {
  const bool rate = std::string_view(limit.key) == "velocity" || std::string_view(limit.key) == "effort";
  return rate && value == 0.0;
}

/// In URDF a bound that is not there is 0; where there is none, the file has no range.
void complete_range(Draft& draft, const Node& joint, Node& limit) {
  const bool lower = limit.get("lower") != nullptr, upper = limit.get("upper") != nullptr;
  if (lower == upper) return;
  const char* missing = lower ? "upper" : "lower";
  limit.set(missing, 0.0);
  draft.note(fmt::format("joint '{}' limit {}", joint.text("name"), missing), "0",
             "the file has the other end only, and in URDF a missing one is 0");
}

/// A joint that cannot leave its place is a part of what carries it.
bool lock(Draft& draft, Node& joint) {
  const Node* limit = joint.child("limit");
  const auto lower = limit != nullptr ? limit->number("lower") : std::nullopt;
  const auto upper = limit != nullptr ? limit->number("upper") : std::nullopt;
  if (!lower || !upper || *lower != *upper || joint.text("type") == "continuous") return false;
  const bool slides = joint.text("type") == "prismatic";
  const Node* axis_node = joint.child("axis");
  const Eigen::Vector3d axis = axis_node != nullptr ? axis_node->vector("xyz", Eigen::Vector3d::UnitX())
                                                    : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  if (!(axis.norm() > 0.0)) return false;
  Eigen::Isometry3d X = joint.origin();
  if (slides) {
    X.translate(*lower * axis.normalized());
  } else {
    X.rotate(Eigen::AngleAxisd(*lower, axis.normalized()));
  }
  if (*lower != 0.0) joint.set_origin(X.translation(), rpy_of(X.linear()));
  draft.note(fmt::format("joint '{}'", joint.text("name")),
             fmt::format("fixed at {:g} {}", *lower, slides ? "m" : "rad"), "both ends of its range are the same");
  freeze(joint);
  return true;
}

void complete_limits(Draft& draft, Node& joint) {
  const std::string name = joint.text("name");
  const bool slides = joint.text("type") == "prismatic";
  const bool endless = joint.text("type") == "continuous";
  Node& limit = joint.need("limit");
  if (!endless) complete_range(draft, joint, limit);
  const bool no_range = !endless && !limit.get("lower");
  for (const LimitDefault& row : kLimits) {
    const bool range = std::string_view(row.key) == "lower" || std::string_view(row.key) == "upper";
    if (range && endless) {
      limit.drop(row.key);
      continue;
    }
    const auto value = limit.number(row.key);
    const bool missing = limit.get(row.key) == nullptr || (value && unusable(row, *value)) || (range && no_range);
    if (!missing) continue;
    limit.set(row.key, slides ? row.sliding : row.turning);
    if (std::string_view(row.key) == "effort") {
      draft.without_effort.push_back(name);
    } else {
      draft.note(
          fmt::format("joint '{}' limit {}", name, row.key),
          fmt::format("{:g} {}", slides ? row.sliding : row.turning, slides ? row.sliding_unit : row.turning_unit),
          "the file has none");
    }
  }
}

/// Movable joints from the root down to a link.
int joints_to(Draft& draft, std::string link) {
  int count = 0;
  std::set<std::string> seen;
  while (seen.insert(link).second) {
    const Node* joint = draft.joint_above(link);
    if (joint == nullptr) return count;
    count += is_movable(*joint) ? 1 : 0;
    link = parent_of(*joint);
  }
  return count;
}

/// How likely a link behind the last joint is the flange, by the words that makers use; a bare frame is likelier than a
/// body. tool0 has z out of the face by ROS-Industrial's convention; their "flange" has x.
int flange_rank(const Node& link) {
  constexpr std::array<std::string_view, 8> kWords = {"tool0",   "link_8", "link8",        "ee_link",
                                                      "link_ee", "flange", "end_effector", "effector_link"};
  const std::string name = link.text("name");
  for (std::size_t i = 0; i < kWords.size(); ++i) {
    if (name == kWords[i] || name.ends_with(kWords[i])) return static_cast<int>(kWords.size() - i) + 2;
  }
  if (name.find("flange") != std::string::npos) return 2;
  return link.child("visual") == nullptr && link.child("inertial") == nullptr ? 1 : 0;
}

/// Whether some joint moves the link or what hangs on it.
bool moves_below(Draft& draft, const Node& joint) {
  std::vector<const Node*> open{&joint};
  for (std::size_t i = 0; i < open.size() && open.size() <= kMostJoints; ++i) {
    if (is_movable(*open[i])) return true;
    for (const Node* next : draft.joints_below(child_of(*open[i]))) open.push_back(next);
  }
  return false;
}

/// Joints of the smallest arms that are named for what they carry.
constexpr int kSmallArm = 4;

bool has_word(const std::string& name, std::span<const std::string_view> words) {
  std::string text = name;
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::any_of(words, [&](std::string_view word) { return text.find(word) != text.npos; });
}

/// Frames of what looks at the work, not of what carries it.
constexpr std::array<std::string_view, 7> kSensorWords = {"camera", "optical",   "lidar", "laser",
                                                          "depth",  "realsense", "imu"};
constexpr std::array<std::string_view, 5> kFingerWords = {"finger", "gripper", "jaw", "knuckle", "gripping"};

/// A finger that drives the others, which follow it: the last joint behind those of an arm.
bool drives_fingers(Draft& draft, const Node& joint) {
  if (!is_movable(joint) || joints_to(draft, parent_of(joint)) < kSmallArm) return false;
  if (!draft.mimicked.contains(joint.text("name")) && !has_word(joint.text("name"), kFingerWords)) return false;
  return std::ranges::none_of(draft.joints_below(child_of(joint)),
                              [&](const Node* below) { return moves_below(draft, *below); });
}

/// Whether fingers are driven somewhere below the link.
bool carries_fingers(Draft& draft, const std::string& link) {
  std::vector<std::string> open{link};
  for (std::size_t i = 0; i < open.size() && open.size() <= kMostJoints; ++i) {
    for (const Node* joint : draft.joints_below(open[i])) {
      if (drives_fingers(draft, *joint)) return true;
      open.push_back(child_of(*joint));
    }
  }
  return false;
}

/// A part of a gripper: fixed to what the arm moves last, with fingers below it, or named for them.
bool part_of_gripper(Draft& draft, const Node& link) {
  const std::string name = link.text("name");
  const Node* joint = draft.joint_above(name);
  if (joint == nullptr || is_movable(*joint) || flange_rank(link) > 1) return false;
  return carries_fingers(draft, name) || has_word(name, kFingerWords);
}

/// Fingers move too: they hang, several of them, on one link behind the arm's joints, or one of them drives the rest.
bool behind_fingers(Draft& draft, std::string link) {
  std::set<std::string> seen;
  while (const Node* joint = draft.joint_above(link)) {
    if (!seen.insert(link).second) return false;
    if (drives_fingers(draft, *joint)) return true;
    link = parent_of(*joint);
    if (joints_to(draft, link) < kSmallArm) return false;
    if (const Node* carrier = draft.link(link); carrier != nullptr && part_of_gripper(draft, *carrier)) return true;
    const auto below = draft.joints_below(link);
    if (std::ranges::count_if(below, [&](const Node* one) { return moves_below(draft, *one); }) > 1) return true;
  }
  return false;
}

/// A candidate: better names before longer chains, the first one in the order of the file before its equals.
struct Tip {
  std::string link;
  int rank = -1, joints = 0;
  [[nodiscard]] bool better_than(const Tip& other) const {
    const bool named = joints >= kSmallArm && rank > kNamed,
               other_named = other.joints >= kSmallArm && other.rank > kNamed;
    if (named != other_named) return named;
    if (named) return rank > other.rank;
    return joints != other.joints ? joints > other.joints : rank > other.rank;
  }
  static constexpr int kNamed = 2;
};

void guess_flange(Draft& draft) {
  Tip best;
  for (Node* link : draft.robot.all("link")) {
    const std::string name = link->text("name");
    const Tip tip{name, flange_rank(*link), joints_to(draft, name)};
    if (tip.joints == 0 || part_of_gripper(draft, *link) || behind_fingers(draft, name)) continue;
    if (has_word(name, kSensorWords)) continue;
    if (tip.better_than(best)) best = tip;
  }
  if (best.link.empty()) {
    draft.diagnostics.error(Code::kInvalidValue, "", "no joint moves", "Give the URDF of an arm");
    return;
  }
  draft.flange = best.link;
  draft.note("flange", fmt::format("link '{}'", best.link),
             best.rank >= Tip::kNamed
                 ? "by its name, behind the last joint; z must point out of the face"
                 : "what the last joint moves; check that z points out of the face, or give --flange");
}

void guess_base(Draft& draft) {
  std::string link = draft.flange;
  std::vector<std::string> way{link};
  std::set<std::string> seen;
  while (const Node* joint = draft.joint_above(link)) {
    if (!seen.insert(link).second) break;
    link = parent_of(*joint);
    way.push_back(link);
  }
  // A link without any body above the base is a room, not a part of the arm; "base" by name counts before that.
  std::ranges::reverse(way);
  std::size_t at = 0;
  const auto room = [&](std::size_t i) {
    const Node* node = draft.link(way[i]);
    const Node* below = draft.joint_above(way[i + 1]);
    return node != nullptr && node->children.empty() && !is_movable(*below) && !way[i].ends_with("base_link") &&
           !way[i].ends_with("base");
  };
  while (at + 1 < way.size() && room(at)) ++at;
  draft.base = way[at];
  draft.note("base", fmt::format("link '{}'", draft.base),
             "the root of the chain; z must point up, out of the mounting face");
}

bool below(Draft& draft, std::string link, const std::string& top) {
  std::set<std::string> seen;
  while (link != top) {
    const Node* joint = draft.joint_above(link);
    if (joint == nullptr || !seen.insert(link).second) return false;
    link = parent_of(*joint);
  }
  return true;
}

/// Leaves out these links, with the joints above them and the one above the base.
std::size_t drop_links(Draft& draft, const std::set<std::string>& links) {
  std::erase_if(draft.robot.children, [&](const Node& node) {
    const bool above = !draft.base.empty() && node.name == "joint" && child_of(node) == draft.base;
    const bool joint = node.name == "joint" && links.contains(child_of(node));
    return above || joint || (node.name == "link" && links.contains(node.text("name")));
  });
  return links.size();
}

std::set<std::string> links_below(Draft& draft, const std::string& top) {
  std::set<std::string> links;
  for (const Node* link : draft.robot.all("link"))
    if (below(draft, link->text("name"), top)) links.insert(link->text("name"));
  return links;
}

void drop_above_base(Draft& draft) {
  std::set<std::string> above;
  for (const Node* link : draft.robot.all("link"))
    if (!below(draft, link->text("name"), draft.base)) above.insert(link->text("name"));
  if (drop_links(draft, above) > 0)
    draft.note("left out", fmt::format("{} links", above.size()), "they are not below the base");
}

/// What hangs on a joint of a kind that arms have not (a camera that floats) is no part of the arm, unless it carries
/// the flange: then the checker refuses it.
void drop_strange(Draft& draft) {
  constexpr std::array<std::string_view, 3> kStrange = {"floating", "planar", "spherical"};
  for (bool again = true; again;) {
    again = false;
    for (const Node* joint : draft.robot.all("joint")) {
      if (std::ranges::find(kStrange, joint->text("type")) == kStrange.end()) continue;
      const std::string name = joint->text("name"), kind = joint->text("type"), top = child_of(*joint);
      if (below(draft, draft.flange, top)) continue;
      const std::size_t count = drop_links(draft, links_below(draft, top));
      draft.note(fmt::format("joint '{}'", name), fmt::format("left out, with {} link{}", count, count == 1 ? "" : "s"),
                 fmt::format("{} joints are not simulated, and it does not carry the flange", kind));
      again = true;
      break;
    }
  }
}

/// What the options leave out.
void drop_unwanted(Draft& draft) {
  for (const std::string& top : draft.without) {
    if (draft.link(top) == nullptr) {
      std::vector<std::string> names;
      for (const Node* node : draft.robot.all("link")) names.push_back(node->text("name"));
      draft.diagnostics.error(Code::kUnknownName, "--without", fmt::format("there is no link '{}'", top),
                              nearest_choice(top, names));
      continue;
    }
    if (draft.joint_above(top) == nullptr || (!draft.flange.empty() && below(draft, draft.flange, top))) {
      draft.diagnostics.error(Code::kInvalidValue, "--without", fmt::format("'{}' is not beside the arm", top),
                              "Name a link that does not carry the flange");
      continue;
    }
    const std::size_t count = drop_links(draft, links_below(draft, top));
    draft.note(fmt::format("link '{}'", top), fmt::format("left out, {} link{}", count, count == 1 ? "" : "s"),
               "--without");
  }
}

/// Joints between links that are not there; links that hang on themselves, or on two joints: no way leads up from them.
void check_tree(Draft& draft) {
  for (const Node* joint : draft.robot.all("joint")) {
    for (const std::string& link : {parent_of(*joint), child_of(*joint)}) {
      if (draft.link(link) != nullptr) continue;
      draft.diagnostics.error(Code::kUnknownName, "",
                              fmt::format("joint '{}': link '{}' does not exist", joint->text("name"), link));
    }
  }
  std::set<std::string> children;
  for (const Node* joint : draft.robot.all("joint")) {
    if (children.insert(child_of(*joint)).second) continue;
    draft.diagnostics.error(Code::kDuplicate, "", fmt::format("link '{}' has a second parent", child_of(*joint)),
                            "Break the loop: a robot is a tree");
  }
  for (const Node* start : draft.robot.all("link")) {
    std::set<std::string> seen;
    std::string link = start->text("name");
    while (const Node* joint = draft.joint_above(link)) {
      if (!seen.insert(link).second) break;
      link = parent_of(*joint);
    }
    if (link != start->text("name") || !seen.contains(link)) continue;
    draft.diagnostics.error(Code::kInvalidValue, "", fmt::format("the joints form a loop through link '{}'", link),
                            "Break the loop: a robot is a tree");
    return;
  }
}

}  // namespace

void complete_joints(Draft& draft) {
  for (Node* joint : draft.robot.all("joint")) {
    const std::string name = joint->text("name");
    if (const Node* mimic = joint->child("mimic")) {
      draft.mimicked.insert(mimic->text("joint"));
      draft.note(fmt::format("joint '{}'", name), "fixed at zero",
                 fmt::format("it mimics '{}', and couplings are not simulated", mimic->text("joint")));
      freeze(*joint);
    }
    if (is_movable(*joint) && !lock(draft, *joint)) complete_limits(draft, *joint);
    if (joint->text("type") == "fixed") {
      for (const char* word : {"axis", "limit", "dynamics"}) joint->drop_children(word);
    }
  }
}

void guess_chain(Draft& draft) {
  check_tree(draft);
  for (const auto& [option, link] : {std::pair{"--base", draft.base}, std::pair{"--flange", draft.flange}}) {
    if (link.empty() || draft.link(link) != nullptr) continue;
    std::vector<std::string> names;
    for (const Node* node : draft.robot.all("link")) names.push_back(node->text("name"));
    draft.diagnostics.error(Code::kUnknownName, option, fmt::format("there is no link '{}'", link),
                            nearest_choice(link, names));
  }
  if (draft.diagnostics.has_errors()) return;
  drop_unwanted(draft);
  if (draft.diagnostics.has_errors()) return;
  if (draft.flange.empty()) guess_flange(draft);
  if (draft.diagnostics.has_errors()) return;
  if (draft.base.empty()) guess_base(draft);
  if (!below(draft, draft.flange, draft.base)) {
    draft.diagnostics.error(Code::kInvalidValue, "--base",
                            fmt::format("'{}' does not carry '{}'", draft.base, draft.flange));
    return;
  }
  drop_above_base(draft);
  drop_strange(draft);
  for (Node* joint : draft.robot.all("joint")) {
    if (!is_movable(*joint) || below(draft, draft.flange, child_of(*joint))) continue;
    draft.note(fmt::format("joint '{}'", joint->text("name")), "fixed at zero",
               "it is not on the chain from base to flange; --without LINK leaves out a gripper");
    freeze(*joint);
  }
}

}  // namespace takt::tools
