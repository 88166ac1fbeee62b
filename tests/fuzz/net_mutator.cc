#include "tests/fuzz/net_mutator.h"

#include <array>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/registry.h"

namespace takt::test {
namespace {

using Json = nlohmann::ordered_json;
using net::PrimitiveInfo;
using net::Registry;

class Mutator {
 public:
  Mutator(Json& net, Random& random) : net_(net), random_(random) {}

  void change() {
    using Change = void (Mutator::*)();
    static constexpr std::array<Change, 9> kChanges = {
        &Mutator::add_primitive, &Mutator::add_linked_primitive, &Mutator::add_link,
        &Mutator::add_link,      &Mutator::set_parameter,        &Mutator::erase_one,
        &Mutator::delay_a_link,  &Mutator::wrap_in_fragment,     &Mutator::change_inside};
    (this->*kChanges[below(kChanges.size())])();
  }

 private:
  std::size_t below(std::size_t n) { return random_.bits() % n; }

  Json& list(const char* name) {
    Json& list = net_[name];
    if (!list.is_array()) list = Json::array();
    return list;
  }
  Json* any_of(const char* name) {
    Json& all = list(name);
    return all.empty() ? nullptr : &all[below(all.size())];
  }
  const PrimitiveInfo& any_type() {
    static const std::vector<const PrimitiveInfo*> kAll = Registry::global().all();
    return *kAll[below(kAll.size())];
  }
  static const PrimitiveInfo* type_of(const Json& primitive) {
    if (!primitive.is_object() || !primitive.contains("type") || !primitive["type"].is_string()) return nullptr;
    return Registry::global().find(primitive["type"].get<std::string>());
  }
  static std::string id_of(const Json& primitive) {
    return primitive.is_object() && primitive.contains("id") && primitive["id"].is_string()
               ? primitive["id"].get<std::string>()
               : std::string("x");
  }

  std::string add(const PrimitiveInfo& info) {
    const std::string id = fmt::format("p{}", list("primitives").size());
    Json parameters = Json::object();
    for (const auto& parameter : info.parameters) {
      if (parameter.fallback.empty()) parameters[parameter.name] = value_for(parameter);
    }
    list("primitives").push_back({{"id", id}, {"type", info.type}, {"parameters", parameters}});
    return id;
  }
  void add_primitive() { add(any_type()); }

  /// Every input fed by an output of its type, or by a constant.
  void add_linked_primitive() {
    const PrimitiveInfo& info = any_type();
    const std::string id = add(info);
    for (const auto& input : info.inputs) {
      const std::string source = output_of(input.type);
      if (source.empty()) {
        Json& primitive = list("primitives").back();
        primitive["parameters"][input.name] = value_of(net::name_of(input.type));
      } else {
        list("links").push_back({{"from", source}, {"to", id + "." + input.name}});
      }
    }
  }
  std::string output_of(net::ValueType type) {
    std::vector<std::string> found;
    for (const Json& primitive : list("primitives")) {
      const PrimitiveInfo* info = type_of(primitive);
      if (info == nullptr) continue;
      for (const auto& output : info->outputs) {
        if (output.type == type) found.push_back(id_of(primitive) + "." + output.name);
      }
    }
    return found.empty() ? "" : found[below(found.size())];
  }

  void add_link() {
    const Json* to = any_of("primitives");
    const PrimitiveInfo* info = to == nullptr ? nullptr : type_of(*to);
    if (info == nullptr || info->inputs.empty()) return;
    const auto& input = info->inputs[below(info->inputs.size())];
    const std::string from = output_of(input.type);
    if (from.empty()) return;
    Json link = {{"from", from}, {"to", id_of(*to) + "." + input.name}};
    Json& links = list("links");
    for (Json& other : links) {  // an input takes one link
      if (other.is_object() && other.contains("to") && other["to"] == link["to"]) {
        other = link;
        return;
      }
    }
    links.push_back(link);
  }

  void set_parameter() {
    Json* primitive = any_of("primitives");
    const PrimitiveInfo* info = primitive == nullptr ? nullptr : type_of(*primitive);
    if (info == nullptr || info->parameters.empty()) return;
    const auto& parameter = info->parameters[below(info->parameters.size())];
    Json& parameters = (*primitive)["parameters"];
    if (!parameters.is_object()) parameters = Json::object();
    parameters[parameter.name] = value_for(parameter);
  }

  void erase_one() {
    static constexpr std::array<const char*, 3> kLists = {"primitives", "links", "fragments"};
    Json& all = list(kLists[below(kLists.size())]);
    if (!all.empty()) all.erase(below(all.size()));
  }

  void delay_a_link() {
    Json* link = any_of("links");
    if (link == nullptr || !link->is_object()) return;
    (*link)["delayed"] = random_.unit() < 0.8;
    if (random_.unit() < 0.5) (*link)["initial"] = value_of(any_type_name());
  }

  void wrap_in_fragment() {
    Json inner = Json::object();
    inner["primitives"] = Json::array();
    Json& primitives = list("primitives");
    for (std::size_t i = below(4) + 1; i > 0 && !primitives.empty(); --i) {
      const std::size_t at = below(primitives.size());
      inner["primitives"].push_back(primitives[at]);
      primitives.erase(at);
    }
    const std::string id = fmt::format("f{}", list("fragments").size());
    list("fragments")
        .push_back({{"id", id}, {"when_inactive", random_.unit() < 0.5 ? "keep" : "reset"}, {"net", inner}});
    const std::string source = output_of(net::ValueType::kBoolean);
    if (!source.empty()) list("links").push_back({{"from", source}, {"to", id + ".active"}});
  }

  void change_inside() {
    Json* fragment = any_of("fragments");
    if (fragment == nullptr || !fragment->is_object() || !(*fragment)["net"].is_object()) return;
    Mutator((*fragment)["net"], random_).change();
  }

  std::string_view any_type_name() { return net::name_of(static_cast<net::ValueType>(below(10))); }

  Json number() {
    static constexpr std::array<double, 12> kNumbers = {0.0, 1.0,    -1.0,  0.5,    2.0,  1e-9,
                                                        1e9, -1e300, 1e308, 5e-324, -0.0, 3.141592653589793};
    return random_.unit() < 0.6 ? Json(kNumbers[below(kNumbers.size())]) : Json(random_.uniform(-10.0, 10.0));
  }
  Json numbers(std::size_t count) {
    Json all = Json::array();
    for (std::size_t i = 0; i < count; ++i) all.push_back(number());
    return all;
  }
  Json value_of(std::string_view type) {
    if (random_.unit() < 0.05) return nullptr;
    if (type == "Boolean") return random_.unit() < 0.5;
    if (type == "Integer") {
      return random_.unit() < 0.8 ? Json(static_cast<std::int64_t>(below(9)) - 2)
                                  : Json(static_cast<std::int64_t>(random_.bits()));
    }
    if (type == "String") return random_.unit() < 0.5 ? "arm" : "text";
    if (type == "Vector") return numbers(3);
    if (type == "Rotation") return {0.6, 0.0, 0.8, 0.0};
    if (type == "Frame") return {{"position", numbers(3)}, {"quaternion", {1.0, 0.0, 0.0, 0.0}}};
    if (type == "Twist") return {{"linear", numbers(3)}, {"angular", numbers(3)}};
    if (type == "Wrench") return {{"force", numbers(3)}, {"torque", numbers(3)}};
    if (type == "Joints") return numbers(below(14));
    return number();
  }
  Json value_for(const PrimitiveInfo::Parameter& parameter) {
    if (parameter.type.starts_with("device:arm")) return "arm";
    if (parameter.type.starts_with("device:")) return "sensor";
    if (parameter.type == "json") return structure();
    const std::string_view words = parameter.spec.range;
    if (parameter.type == "String" && words.find('|') != std::string_view::npos) {
      return std::string(words.substr(0, words.find('|')));
    }
    return value_of(parameter.type);
  }
  /// What stands in the parameters that have a form of their own.
  Json structure() {
    switch (below(4)) {
      case 0:
        return {{"acceleration_max", number()}, {"jerk_max", number()}};
      case 1:
        return Json::array({numbers(2), numbers(2)});
      case 2:
        return {{"kind", "joint_line"}, {"start", numbers(3)}, {"goal", numbers(3)}};
      default:
        return {{"kind", "cartesian_line"}, {"start", numbers(7)},    {"direction", numbers(3)},
                {"length_m", number()},     {"axis", numbers(3)},     {"angle_rad", number()},
                {"held_start", numbers(1)}, {"held_goal", numbers(1)}};
    }
  }

  Json& net_;
  Random& random_;
};

}  // namespace

std::vector<std::string> net_words() {
  std::set<std::string> words = {"name",          "primitives", "links", "fragments", "id",      "type",
                                 "parameters",    "from",       "to",    "delayed",   "initial", "net",
                                 "inputs",        "outputs",    "port",  "active",    "keep",    "reset",
                                 "when_inactive", "arm",        "sensor"};
  for (const PrimitiveInfo* info : Registry::global().all()) {
    words.insert(info->type);
    for (const auto& port : info->inputs) words.insert(port.name);
    for (const auto& port : info->outputs) words.insert(port.name);
    for (const auto& parameter : info->parameters) words.insert(parameter.name);
  }
  return {words.begin(), words.end()};
}

std::string mutated_net(const Json& net, Random& random) {
  Json changed = net;
  if (changed.is_object()) {
    Mutator mutator(changed, random);
    for (std::uint64_t i = 1 + random.bits() % 4; i > 0; --i) mutator.change();
  }
  return changed.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace takt::test
