#include "core/program/tree/measured_json.h"

#include <array>

#include <nlohmann/json.hpp>

#include "core/program/language/value.h"

namespace takt::activity {
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

Json frames_json(const Variables& variables, const command::Cell& cell) {
  Json json = Json::object();
  const auto add = [&](const std::string& name) {
    if (const auto X = cell.frames.pose(name)) json[name] = pose_to_json(*X);
  };
  for (const auto& [name, pose] : variables.estimates) add(name);
  for (const auto& [name, object] : cell.objects) add(name);
  return json;
}

Json carried_json(const CarriedPart& part) {
  return {{"object", part.object},
          {"told", part.told},
          {"in_tool", pose_to_json(part.X_TO)},
          {"mass_before", part.before.payload.mass},
          {"centre_before", vector_json(part.before.payload.p_FC)},
          {"tool_before", pose_to_json(part.before.X_FT)}};
}

CarriedPart carried_of(const Json& json) {
  CarriedPart part;
  part.object = json.at("object").get<std::string>();
  part.told = json.at("told").get<bool>();
  part.X_TO = pose_from_json(json.at("in_tool"));
  part.before.payload.mass = json.at("mass_before").get<double>();
  part.before.payload.p_FC = vector_of(json.at("centre_before"));
  part.before.X_FT = pose_from_json(json.at("tool_before"));
  return part;
}

}  // namespace

Json measured_to_json(const Variables& variables, const command::Cell& cell) {
  Json json;
  json["contacts"] = object_of(variables.contacts, [](const world::Contact& contact) {
    return Json{{"name", contact.name}, {"at", vector_json(contact.p_R)}, {"radius", contact.radius}};
  });
  json["estimates"] = object_of(variables.estimates, [](const Eigen::Isometry3d& X) { return pose_to_json(X); });
  json["residuals"] = object_of(variables.residuals, [](double residual) { return Json(residual); });
  json["touches"] = object_of(variables.touches, [](const Touch& touch) {
    return Json{{"at", vector_json(touch.p_W)}, {"radius", touch.radius}, {"cycle", touch.cycle}};
  });
  json["carried"] = object_of(variables.carried, carried_json);
  json["monitors"] = object_of(variables.monitors, [](const auto& of_net) {
    return object_of(of_net, [](const std::string& text) { return Json(text); });
  });
  json["biases"] = object_of(variables.biases, [](const net::Wrench& bias) {
    return Json{{"force", vector_json(bias.force)}, {"torque", vector_json(bias.torque)}};
  });
  json["frames"] = frames_json(variables, cell);
  return json;
}

Diagnostics measured_from_json(const Json& json, Variables& variables, command::Cell& cell) {
  Variables read;
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
  for (const auto& [name, part] : json.at("carried").items()) read.carried[name] = carried_of(part);
  for (const auto& [net, monitors] : json.at("monitors").items()) {
    for (const auto& [name, text] : monitors.items()) read.monitors[net][name] = text.get<std::string>();
  }
  for (const auto& [name, bias] : json.at("biases").items()) {
    read.biases[name] = {.force = vector_of(bias.at("force")), .torque = vector_of(bias.at("torque"))};
  }
  Diagnostics diagnostics;
  for (const auto& [name, pose] : json.at("frames").items()) {
    diagnostics.append(cell.frames.set(name, std::string(world::FrameGraph::kWorld), pose_from_json(pose)), "/frames");
  }
  variables = std::move(read);
  return diagnostics;
}

}  // namespace takt::activity
