#include "core/program/language/value.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

struct KindName {
  Type::Kind kind;
  std::string_view name;
};

constexpr std::array<KindName, 6> kKinds{{{Type::Kind::kUnknown, "anything"},
                                          {Type::Kind::kBoolean, "boolean"},
                                          {Type::Kind::kNumber, "number"},
                                          {Type::Kind::kText, "text"},
                                          {Type::Kind::kPose, "pose"},
                                          {Type::Kind::kList, "list"}}};

std::string_view name_of(Type::Kind kind) { return std::ranges::find(kKinds, kind, &KindName::kind)->name; }

Json type_to_json(const Type& type) {
  Json json{{"type", name_of(type.kind)}};
  if (type.kind == Type::Kind::kNumber) json["unit"] = net::to_string(type.unit);
  if (type.kind == Type::Kind::kList) json["of"] = type_to_json(type.element.front());
  return json;
}

Type type_of_json(const Json& json) {
  const auto name = json.at("type").get<std::string>();
  if (name == "list") return Type::list_of(type_of_json(json.at("of")));
  if (name == "number") return Type::number(unit_dimension(json.at("unit").get<std::string>()));
  const auto found = std::ranges::find(kKinds, name, &KindName::name);
  return {found == kKinds.end() ? Type::Kind::kUnknown : found->kind, {}, {}};
}

/// A bare number has the unit of its key.
void adopt(const Type& place, Value& value) {
  if (place.kind == Type::Kind::kUnknown) return;
  value.type = place;
  if (place.kind != Type::Kind::kList || value.null()) return;
  for (Value& element : std::get<std::vector<Value>>(value.data)) adopt(place.element.front(), element);
}

}  // namespace

net::Dimension unit_dimension(std::string_view unit) {
  const auto terms = net::parse_unit(unit);
  return terms && terms->size() == 1 ? terms->front().dimension : net::Dimension{};
}

std::string to_string(const Type& type) {
  if (type.kind == Type::Kind::kList) return "list of " + to_string(type.element.front());
  if (type.kind != Type::Kind::kNumber) return std::string(name_of(type.kind));
  return type.unit.zero() ? "number without a unit" : "number in " + net::to_string(type.unit);
}

bool accepts(const Type& wanted, const Type& given) {
  if (wanted.kind == Type::Kind::kUnknown || given.kind == Type::Kind::kUnknown) return true;
  if (wanted.kind != given.kind) return false;
  if (wanted.kind == Type::Kind::kNumber) return given.unit.zero() || wanted.unit == given.unit;
  return wanted.kind != Type::Kind::kList || accepts(wanted.element.front(), given.element.front());
}

Type common(const Type& a, const Type& b) {
  if (a.kind == Type::Kind::kUnknown) return b;
  if (b.kind == Type::Kind::kUnknown) return a;
  if (a.kind != b.kind) return {};
  if (a.kind == Type::Kind::kList) return Type::list_of(common(a.element.front(), b.element.front()));
  if (a.kind == Type::Kind::kNumber && a.unit != b.unit) return {};
  return a;
}

std::optional<Type> type_from_text(std::string_view text, std::string_view unit) {
  constexpr std::string_view kList = "list of ";
  if (text.starts_with(kList)) {
    const auto element = type_from_text(text.substr(kList.size()), unit);
    return element ? std::optional(Type::list_of(*element)) : std::nullopt;
  }
  const auto found = std::ranges::find(kKinds, text, &KindName::name);
  if (found == kKinds.end() || found->kind == Type::Kind::kUnknown || found->kind == Type::Kind::kList) return {};
  if (found->kind != Type::Kind::kNumber) return Type{found->kind, {}, {}};
  const auto terms = net::parse_unit(unit);
  if (!unit.empty() && (!terms || terms->size() != 1 || !terms->front().variables.empty())) return {};
  return Type::number(unit_dimension(unit));
}

Value Value::of(std::vector<Value> values) {
  Type element;
  for (const Value& value : values) element = common(element, value.type);
  return {Type::list_of(std::move(element)), std::move(values)};
}

std::string to_string(const Value& value) {
  if (value.null()) return "unknown";
  switch (value.data.index()) {
    case 1:
      return value.boolean() ? "true" : "false";
    case 2:
      return value.type.unit.zero() ? fmt::format("{:.6g}", value.number())
                                    : fmt::format("{:.6g} {}", value.number(), net::to_string(value.type.unit));
    case 3:
      return value.text();
    case 4: {
      const Eigen::Vector3d p = value.pose().translation();
      return fmt::format("({:.5g}, {:.5g}, {:.5g}) m", p.x(), p.y(), p.z());
    }
    default: {
      std::vector<std::string> parts;
      for (const Value& element : value.list()) parts.push_back(to_string(element));
      return fmt::format("[{}]", fmt::join(parts, ", "));
    }
  }
}

Json pose_to_json(const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const Eigen::Vector3d p = X.translation();
  return {{"position_m", {p.x(), p.y(), p.z()}}, {"quaternion", {q.w(), q.x(), q.y(), q.z()}}};
}

Eigen::Isometry3d pose_from_json(const Json& json) {
  const auto p = json.at("position_m").get<std::array<double, 3>>();
  const auto q = json.at("quaternion").get<std::array<double, 4>>();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << p[0], p[1], p[2];
  X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  return X;
}

Json to_json(const Value& value) {
  Json json = type_to_json(value.type);
  Json& payload = json["value"];
  switch (value.data.index()) {
    case 0:
      break;
    case 1:
      payload = value.boolean();
      break;
    case 2:
      payload = value.number();
      break;
    case 3:
      payload = value.text();
      break;
    case 4:
      payload = pose_to_json(value.pose());
      break;
    default:
      payload = Json::array();
      for (const Value& element : value.list()) payload.push_back(to_json(element));
  }
  return json;
}

Value value_from_json(const Json& json) {
  Value value = Value::unknown(type_of_json(json));
  const Json& payload = json.at("value");
  if (payload.is_null()) return value;
  switch (value.type.kind) {
    case Type::Kind::kUnknown:
      break;
    case Type::Kind::kBoolean:
      value.data = payload.get<bool>();
      break;
    case Type::Kind::kNumber:
      value.data = payload.get<double>();
      break;
    case Type::Kind::kText:
      value.data = payload.get<std::string>();
      break;
    case Type::Kind::kPose:
      value.data = pose_from_json(payload);
      break;
    case Type::Kind::kList: {
      std::vector<Value> elements;
      for (const Json& element : payload) elements.push_back(value_from_json(element));
      value.data = std::move(elements);
    }
  }
  return value;
}

Variable* Scope::find(std::string_view name) {
  const auto found = own_.find(name);
  if (found != own_.end()) return &found->second;
  return parent_ ? parent_->find(name) : nullptr;
}

std::vector<std::string> Scope::names() const {
  std::vector<std::string> names = parent_ ? parent_->names() : std::vector<std::string>{};
  for (const auto& [name, variable] : own_) names.push_back(name);
  return names;
}

void Scope::assign(Variable& variable, Value value, bool rehearsing) {
  if (value.null() && rehearsing && variable.nominal) value = *variable.nominal;
  adopt(variable.type, value);
  variable.value = std::move(value);
}

Scope::Saved Scope::save() const {
  Saved saved = parent_ ? parent_->save() : Saved{};
  saved.push_back(own_);
  return saved;
}

void Scope::restore(const Saved& saved) {
  Scope* scope = this;
  for (auto values = saved.rbegin(); values != saved.rend() && scope; ++values, scope = scope->parent_) {
    scope->own_ = *values;
  }
}

Json Scope::to_json() const {
  Json json = Json::object();
  for (const auto& [name, variable] : own_) json[name] = program::to_json(variable.value);
  return json;
}

void Scope::from_json(const Json& json) {
  for (const auto& [name, value] : json.items()) own_.at(name).value = value_from_json(value);
}

bool is_variable_name(std::string_view name) {
  constexpr std::array<std::string_view, 6> kWords{"and", "or", "not", "true", "false", "null"};
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  const auto inside = [&](char c) { return letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0; };
  return !name.empty() && letter(name.front()) && std::ranges::all_of(name, inside) &&
         std::ranges::find(kWords, name) == kWords.end();
}

}  // namespace takt::program
