#include "core/program/tree/measured_json.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/expression/tool_coupling.h"
#include "core/program/language/value.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Vector3d vector_of(const Json& json) {
  const auto v = json.get<std::array<double, 3>>();
  return {v[0], v[1], v[2]};
}

/// A map by name, each value through `write`.
template <class Map, class Write>
Json object_of(const Map& map, const Write& write) {
  Json json = Json::object();
  for (const auto& [name, value] : map) json[name] = write(value);
  return json;
}

// -- The belief: how frames depend on each other, and what grippers hold
// -----------------------------------------------

using Kind = world::Relation::Kind;
constexpr std::array<std::pair<Kind, const char*>, 6> kKinds{{{Kind::kFixed, "fixed"},
                                                              {Kind::kEstimate, "estimate"},
                                                              {Kind::kFlange, "flange"},
                                                              {Kind::kLink, "link"},
                                                              {Kind::kChannel, "channel"},
                                                              {Kind::kUnknown, "unknown"}}};

Json relation_json(const world::Relation& relation) {
  const auto* kind = std::ranges::find(kKinds, relation.kind, &std::pair<Kind, const char*>::first);
  return {{"kind", kind->second},
          {"in", relation.parent},
          {"at", pose_to_json(relation.X_PF)},
          {"source", relation.source},
          {"link", relation.link}};
}

world::Relation relation_of(const Json& json) {
  const auto name = json.at("kind").get<std::string>();
  const auto* kind = std::ranges::find_if(kKinds, [&](const auto& one) { return name == one.second; });
  if (kind == kKinds.end()) throw std::out_of_range("there is no such relation");
  return {.kind = kind->first,
          .parent = json.at("in").get<std::string>(),
          .X_PF = pose_from_json(json.at("at")),
          .source = json.at("source").get<std::string>(),
          .link = json.value("link", std::string())};
}

/// The frames that steps may have changed.
Json frames_json(const activity::Variables& variables, const expression::Cell& cell) {
  Json json = Json::object();
  const auto add = [&](const std::string& name) {
    if (const world::Relation* relation = cell.frames.relation(name)) json[name] = relation_json(*relation);
  };
  for (const auto& [name, pose] : variables.estimates) add(name);
  for (const auto& [name, object] : cell.objects) add(name);
  for (const std::string& name : cell.frames.names()) {
    const world::Relation* relation = cell.frames.relation(name);
    if (relation != nullptr && relation->kind == world::Relation::Kind::kEstimate) add(name);
  }
  return json;
}

Json hold_json(const world::Hold& hold) {
  const auto number = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  return {{"object", hold.object},
          {"arm", hold.arm},
          {"in_flange", pose_to_json(hold.X_FO)},
          {"held_at", vector_json(hold.p_FG)},
          {"mass", hold.mass},
          {"width", number(hold.width)},
          {"force", number(hold.force)},
          {"command", hold.command}};
}

world::Hold hold_of(const Json& json) {
  const auto number = [&](const char* key) {
    return json.at(key).is_null() ? std::nullopt : std::optional(json.at(key).get<double>());
  };
  return {.object = json.at("object").get<std::string>(),
          .arm = json.at("arm").get<std::string>(),
          .X_FO = pose_from_json(json.at("in_flange")),
          .p_FG = vector_of(json.at("held_at")),
          .mass = json.at("mass").get<double>(),
          .width = number("width"),
          .force = number("force"),
          .command = json.at("command").get<std::uint64_t>()};
}

/// Relations may be in any order: one whose parent is not there yet, or hangs on it still, waits for it. The
/// diagnostics are those of a pass in which nothing could be set.
Diagnostics put_back_frames(const Json& frames, expression::Cell& cell) {
  std::vector<std::string> waiting;
  for (const auto& [name, relation] : frames.items()) waiting.push_back(name);
  for (;;) {
    Diagnostics wrong;
    const auto count = std::erase_if(waiting, [&](const std::string& name) {
      const Diagnostics own = cell.frames.set(name, relation_of(frames.at(name)));
      wrong.append(own);
      return !own.has_errors();
    });
    if (count == 0) return wrong;
  }
}

}  // namespace

Json measured_to_json(const activity::Variables& variables, const expression::Cell& cell) {
  Json json;
  json["contacts"] = object_of(variables.contacts, [](const world::Contact& contact) {
    return Json{{"name", contact.name}, {"at", vector_json(contact.p_R)}, {"radius", contact.radius}};
  });
  json["estimates"] = object_of(variables.estimates, [](const Eigen::Isometry3d& X) { return pose_to_json(X); });
  json["residuals"] = object_of(variables.residuals, [](double residual) { return Json(residual); });
  json["touches"] = object_of(variables.touches, [](const activity::Touch& touch) {
    return Json{{"at", vector_json(touch.p_W)}, {"radius", touch.radius}, {"cycle", touch.cycle}};
  });
  json["held"] = object_of(cell.held, hold_json);
  json["monitors"] = object_of(variables.monitors, [](const auto& of_net) {
    return object_of(of_net, [](const std::string& text) { return Json(text); });
  });
  json["biases"] = object_of(variables.biases, [](const net::Wrench& bias) {
    return Json{{"force", vector_json(bias.force)}, {"torque", vector_json(bias.torque)}};
  });
  json["frames"] = frames_json(variables, cell);
  return json;
}

Diagnostics measured_from_json(const Json& json, activity::Variables& variables, expression::Cell& cell) {
  activity::Variables read;
  for (const auto& [name, contact] : json.at("contacts").items()) {
    read.contacts[name] = {contact.at("name").get<std::string>(), vector_of(contact.at("at")),
                           contact.at("radius").get<double>()};
  }
  for (const auto& [name, pose] : json.at("estimates").items()) read.estimates[name] = pose_from_json(pose);
  for (const auto& [name, residual] : json.at("residuals").items()) read.residuals[name] = residual.get<double>();
  for (const auto& [name, touch] : json.at("touches").items()) {
    read.touches[name] = {vector_of(touch.at("at")), touch.at("radius").get<double>(),
                          touch.at("cycle").get<std::int64_t>()};
  }
  for (const auto& [net, monitors] : json.at("monitors").items()) {
    for (const auto& [name, text] : monitors.items()) read.monitors[net][name] = text.get<std::string>();
  }
  for (const auto& [name, bias] : json.at("biases").items()) {
    read.biases[name] = {.force = vector_of(bias.at("force")), .torque = vector_of(bias.at("torque"))};
  }
  std::map<std::string, world::Hold, std::less<>> held;
  for (const auto& [gripper, hold] : json.at("held").items()) held[gripper] = hold_of(hold);
  Diagnostics diagnostics;
  diagnostics.append(put_back_frames(json.at("frames"), cell), "/frames");
  cell.held = std::move(held);
  expression::hang_coupled_tools(cell);
  variables = std::move(read);
  return diagnostics;
}

}  // namespace takt::program
