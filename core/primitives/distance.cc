// Family "distance": how far bodies of the cell are from each other.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/collision/body_pair.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/net/value_json.h"
#include "core/primitives/cell_solids.h"

namespace takt::primitives {
namespace {

using namespace net;
using collision::CellShapes;
using collision::Scene;
using Json = nlohmann::ordered_json;

/// The bodies that a name means: those of a device or object, or one body.
std::vector<int> bodies_named(const Scene& scene, const std::string& name) {
  std::vector<int> bodies;
  for (int i = 0; i < static_cast<int>(scene.bodies().size()); ++i) {
    const collision::Body& body = scene.body(i);
    if (!body.parts.empty() && (body.owner == name || body.name == name)) bodies.push_back(i);
  }
  return bodies;
}

/// The pairs that a parameter names, each once. Diagnostics: no list, names that nothing has.
class PairReader {
 public:
  explicit PairReader(const CellShapes& shapes) : shapes_(shapes) {}

  std::vector<collision::BodyPair> read(const Json& json, Diagnostics& diagnostics) {
    std::vector<collision::BodyPair> pairs;
    const bool list = json.is_array() && std::ranges::all_of(json, [](const Json& one) {
                        return one.is_array() && one.size() == 2 && one[0].is_string() && one[1].is_string();
                      });
    if (!list) {
      diagnostics.error(Code::kWrongType, "/pairs", "no list of pairs of names", R"([["arm", "table"], ...])");
      return pairs;
    }
    for (std::size_t i = 0; i < json.size(); ++i)
      add(named(json[i][0], i, 0, diagnostics), named(json[i][1], i, 1, diagnostics), pairs);
    if (pairs.empty() && !diagnostics.has_errors())
      diagnostics.error(Code::kInvalidValue, "/pairs", "no two bodies that can come nearer to each other",
                        "Name bodies that are neither fixed to each other nor joined by one joint");
    return pairs;
  }

 private:
  std::vector<int> named(const Json& name, std::size_t pair, std::size_t side, Diagnostics& diagnostics) const {
    auto bodies = bodies_named(shapes_.scene, name.get<std::string>());
    if (bodies.empty())
      diagnostics.error(Code::kUnknownName, "/pairs" + pointer_segment(pair) + pointer_segment(side),
                        fmt::format("there is no body '{}'", name.get<std::string>()),
                        nearest_choice(name.get<std::string>(), shapes_.names()));
    return bodies;
  }
  void add(const std::vector<int>& side_a, const std::vector<int>& side_b, std::vector<collision::BodyPair>& pairs) {
    for (const int a : side_a) {
      for (const int b : side_b) {
        if (a == b || shapes_.scene.never_meet(a, b)) continue;
        const auto known = [&](const auto& one) { return std::minmax(one.a(), one.b()) == std::minmax(a, b); };
        if (std::ranges::none_of(pairs, known)) pairs.emplace_back(shapes_.scene, a, b);
      }
    }
  }

  const CellShapes& shapes_;
};

class SmallestDistance final : public Primitive {
 public:
  static constexpr std::size_t kMostArms = 4;

  explicit SmallestDistance(Setup& setup)
      : q_{setup.in<JointArray>("q_1", {.unit = "rad", .doc = "joints of the first arm"}),
           setup.in<JointArray>("q_2", more("joints of the second arm")),
           setup.in<JointArray>("q_3", more("joints of the third arm")),
           setup.in<JointArray>("q_4", more("joints of the fourth arm"))},
        distance_(setup.out<Real>(
            "distance", {.unit = "m", .doc = "of the two bodies that are nearest to each other; 0: they touch"})),
        solids_(setup.device<CellSolids>("solids", CellSolids::kKind, "the bodies of the cell")),
        arms_(setup.json("arms", {.doc = "names of the arms, in the order of the inputs", .example = R"(["arm"])"})),
        pairs_json_(setup.json(
            "pairs", {.doc = "[[NAME, NAME], ...]: devices, objects or bodies", .example = R"([["arm", "block"]])"})),
        placed_(given(setup.optional_json(
            "placed", {.doc = "where what the arms do not move is: {\"objects\": {NAME: {\"on\": BODY or \"\", "
                              "\"pose\": FRAME}}, \"fingers\": {GRIPPER: m}}"}))) {
    if (solids_ == nullptr) {
      setup.costs(kCost);
      return;
    }
    pairs_ = PairReader(solids_->shapes()).read(pairs_json_, diagnostics_);
    setup.costs(kCost + kCostOfPair * static_cast<double>(pairs_.size()));
  }

  Diagnostics prepare() override {
    if (solids_ == nullptr) return std::move(diagnostics_);
    state_ = solids_->shapes().scene.start();
    find_arms();
    place();
    if (diagnostics_.has_errors()) return std::move(diagnostics_);
    const Scene& scene = solids_->shapes().scene;
    std::vector<int> joints;
    for (const auto* mechanism : mechanisms_) joints.insert(joints.end(), mechanism->begin(), mechanism->end());
    const std::vector<bool> moved = scene.moved_by(state_, joints);
    for (const int body : scene.parents_first(state_))
      if (moved[static_cast<std::size_t>(body)]) order_.push_back(body);
    scene.place(state_, poses_);
    // The foot of an arm stands on the floor: of an arm and the floor, the links that move are meant.
    const auto stands = [&](collision::BodyPair& pair) {
      if (moved[static_cast<std::size_t>(pair.a())] || moved[static_cast<std::size_t>(pair.b())]) return false;
      return pair.distance(poses_, kStands) <= kStands;
    };
    if (!std::ranges::all_of(pairs_, stands)) std::erase_if(pairs_, stands);
    nearest_.emplace(scene, std::move(pairs_));
    return {};
  }

  void update(const Cycle&) override {
    for (std::size_t i = 0; i < mechanisms_.size(); ++i) {
      if (q_[i].null()) return distance_.set_null();
      const auto q = q_[i]->map();
      const auto count = std::min(mechanisms_[i]->size(), static_cast<std::size_t>(q.size()));
      for (std::size_t j = 0; j < count; ++j)
        state_.q[static_cast<std::size_t>((*mechanisms_[i])[j])] = q[static_cast<Eigen::Index>(j)];
    }
    solids_->shapes().scene.place_some(state_, order_, poses_);
    distance_.set(nearest_->distance(poses_));
  }

 private:
  static constexpr double kStands = 1e-3;  ///< m: nearer than this what never moves stands on the other
  /// On the reference machine, ns: two arms are put into their posture; a pair by its bounds, few need more.
  static constexpr double kCost = 5000.0, kCostOfPair = 100.0;

  /// Null counts only where there is such an arm.
  static PortSpec more(std::string_view doc) {
    return {.unit = "rad", .doc = doc, .on_null = OnNull::kMayPass, .optional = true};
  }
  static Json given(const Json* json) { return json != nullptr ? *json : Json::object(); }

  void find_arms() {
    const auto& known = solids_->shapes().arms;
    const bool list = arms_.is_array() && !arms_.empty() && arms_.size() <= kMostArms;
    if (!list) return diagnostics_.error(Code::kWrongSize, "/arms", "no list of arms", "Give the names of 1 to 4 arms");
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      const std::string name = arms_[i].is_string() ? arms_[i].get<std::string>() : std::string();
      const auto arm = known.find(name);
      if (arm == known.end()) {
        std::vector<std::string> names;
        for (const auto& [one, mechanism] : known) names.push_back(one);
        diagnostics_.error(Code::kUnknownName, "/arms" + pointer_segment(i), fmt::format("there is no arm '{}'", name),
                           nearest_choice(name, names));
      } else if (i > 0 && !q_[i].bound()) {
        diagnostics_.error(Code::kUnlinkedInput, "/arms" + pointer_segment(i),
                           fmt::format("nothing feeds the joints of '{}'", name), fmt::format("Feed 'q_{}'", i + 1));
      } else {
        mechanisms_.push_back(&arm->second.joints);
      }
    }
  }

  void place() {
    const CellShapes& shapes = solids_->shapes();
    const Json none = Json::object();
    const Json& objects = placed_.is_object() && placed_.contains("objects") ? placed_["objects"] : none;
    const Json& fingers = placed_.is_object() && placed_.contains("fingers") ? placed_["fingers"] : none;
    for (const auto& [name, where] : objects.items()) {
      if (!where.is_object()) continue;
      const int body = shapes.scene.root_of(name);
      const std::string on = where.value("on", std::string());
      const int parent = on.empty() ? -1 : shapes.scene.find(on);
      const std::string pointer = "/placed/objects" + pointer_segment(name);
      Frame X = Frame::Identity();
      diagnostics_.append(net::value_from_json(where.value("pose", Json()), X), pointer + "/pose");
      if (body < 0 || (!on.empty() && parent < 0)) {
        diagnostics_.error(Code::kUnknownName, pointer, fmt::format("no object '{}', or no body '{}'", name, on));
      } else {
        state_.fixings[static_cast<std::size_t>(body)] = {parent, X};
      }
    }
    for (const auto& [name, width] : fingers.items()) {
      const auto gripper = shapes.grippers.find(name);
      if (gripper == shapes.grippers.end() || !width.is_number()) {
        diagnostics_.error(Code::kInvalidValue, "/placed/fingers" + pointer_segment(name), "no width of a gripper",
                           "Give the width of a gripper of the cell, m");
        continue;
      }
      for (const int joint : gripper->second) state_.q[static_cast<std::size_t>(joint)] = 0.5 * width.get<double>();
    }
  }

  std::array<In<JointArray>, kMostArms> q_;
  Out<Real> distance_;
  CellSolids* solids_;
  Json arms_, pairs_json_, placed_;
  Diagnostics diagnostics_;
  std::vector<collision::BodyPair> pairs_;
  std::vector<const std::vector<int>*> mechanisms_;
  std::vector<int> order_;  ///< bodies that the arms move, parents first
  collision::State state_;
  collision::Poses poses_;
  std::optional<collision::NearestPair> nearest_;
};

TAKT_PRIMITIVE(
    SmallestDistance, "distance",
    "The smallest distance between bodies of the cell, never more than it is. Objects and fingers stay where "
    "they are when the net is loaded.");

}  // namespace
}  // namespace takt::primitives
