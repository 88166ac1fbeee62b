#include "core/base/form.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt {
namespace {

using Json = nlohmann::ordered_json;

/// As people write it: 5, not 5.0.
Json plain(double value) {
  constexpr double kMaxWhole = 1e15;
  if (std::trunc(value) == value && std::abs(value) < kMaxWhole) return static_cast<std::int64_t>(value);
  return value;
}

/// The sentence with the unit and what holds without the key: "Lower bound, N; default: none."
std::string description_of(const Key& key) {
  std::string text = key.doc;
  if (text.ends_with('.')) text.pop_back();
  if (!key.unit.empty()) text += ", " + key.unit;
  if (!key.absent.empty()) text += "; default: " + key.absent;
  return text + ".";
}

void add_type(const Key& key, Json& schema) {
  using Type = Key::Type;
  static const Json kPair{{"type", "array"}, {"minItems", 2}, {"maxItems", 2}, {"items", {{"type", "string"}}}};
  switch (key.type) {
    case Type::kNumber:
    case Type::kInteger:
      schema["type"] = key.type == Type::kNumber ? "number" : "integer";
      if (std::isfinite(key.range.low))
        schema[key.range.low_open ? "exclusiveMinimum" : "minimum"] = plain(key.range.low);
      if (std::isfinite(key.range.high)) schema["maximum"] = plain(key.range.high);
      return;
    case Type::kBoolean:
      schema["type"] = "boolean";
      return;
    case Type::kText:
      schema["type"] = "string";
      if (key.min_size > 0) schema["minLength"] = key.min_size;
      return;
    case Type::kChoice:
      schema["enum"] = key.choices;
      return;
    case Type::kTexts:
      return schema.update(kPair);
    case Type::kPairs:
      schema["type"] = "array";
      schema["items"] = kPair;
      return;
    case Type::kVector:
      return schema.update({{"type", "array"}, {"minItems", 3}, {"maxItems", 3}, {"items", {{"type", "number"}}}});
    case Type::kObjects:
      schema["type"] = "array";
      schema["minItems"] = key.min_size;
      schema["items"] = schema_of(*key.elements);
      return;
    case Type::kAny:
      return;
  }
}

Json reference(const std::string& definition) { return {{"$ref", "#/definitions/" + definition}}; }

Json schema_of_key(const Key& key) {
  Json schema;
  // Beside a reference draft-07 ignores every other key, the description too.
  if (key.definition.empty()) {
    add_type(key, schema);
  } else if (key.doc.empty()) {
    return reference(key.definition);
  } else {
    schema["allOf"] = Json::array({reference(key.definition)});
  }
  if (const auto* number = std::get_if<double>(&key.fallback)) schema["default"] = plain(*number);
  if (const auto* text = std::get_if<std::string>(&key.fallback)) schema["default"] = *text;
  schema["description"] = description_of(key);
  return schema;
}

}  // namespace

Key number_key(std::string name, std::string unit, const Range& range, std::string doc) {
  return {.name = std::move(name),
          .type = Key::Type::kNumber,
          .doc = std::move(doc),
          .unit = std::move(unit),
          .range = range};
}
Key integer_key(std::string name, const Range& range, std::string doc) {
  return {.name = std::move(name), .type = Key::Type::kInteger, .doc = std::move(doc), .range = range};
}
Key boolean_key(std::string name, std::string doc) {
  return {.name = std::move(name), .type = Key::Type::kBoolean, .doc = std::move(doc)};
}
Key text_key(std::string name, std::string doc, std::size_t min_size) {
  return {.name = std::move(name), .type = Key::Type::kText, .doc = std::move(doc), .min_size = min_size};
}
Key choice_key(std::string name, std::vector<std::string> choices, std::string doc) {
  return {.name = std::move(name), .type = Key::Type::kChoice, .doc = std::move(doc), .choices = std::move(choices)};
}
Key pair_key(std::string name, std::string doc) {
  return {.name = std::move(name), .type = Key::Type::kTexts, .doc = std::move(doc), .min_size = 2, .max_size = 2};
}
Key pairs_key(std::string name, std::string doc) {
  return {.name = std::move(name), .type = Key::Type::kPairs, .doc = std::move(doc)};
}
Key vector_key(std::string name, std::string unit, std::string doc) {
  return {.name = std::move(name), .type = Key::Type::kVector, .doc = std::move(doc), .unit = std::move(unit)};
}
Key objects_key(std::string name, std::size_t min_size, Form elements, std::string doc) {
  return {.name = std::move(name),
          .type = Key::Type::kObjects,
          .doc = std::move(doc),
          .min_size = min_size,
          .elements = std::make_shared<const Form>(std::move(elements))};
}
Key any_key(std::string name, std::string definition, std::string doc) {
  return {.name = std::move(name), .doc = std::move(doc), .definition = std::move(definition)};
}

const Key& FormReader::row(std::string_view key) const {
  const auto found = std::ranges::find(form_.keys, key, &Key::name);
  if (found != form_.keys.end()) return *found;
  std::fprintf(stderr, "takt: a form has no key '%.*s'\n", static_cast<int>(key.size()), key.data());
  std::abort();
}

double FormReader::number(std::string_view key, std::optional<double> absent) {
  const Key& one = row(key);
  if (const auto* value = std::get_if<double>(&one.fallback)) absent = *value;
  return object_.number(key, absent, one.range);
}

std::int64_t FormReader::integer(std::string_view key, std::optional<std::int64_t> absent) {
  const Key& one = row(key);
  if (const auto* value = std::get_if<double>(&one.fallback)) absent = static_cast<std::int64_t>(*value);
  return object_.integer(key, absent, one.range);
}

bool FormReader::boolean(std::string_view key) {
  (void)row(key);
  return object_.boolean(key);
}

std::string FormReader::text(std::string_view key) {
  const Key& one = row(key);
  const auto* value = std::get_if<std::string>(&one.fallback);
  if (one.required) return object_.text(key);
  return object_.text(key, value ? *value : std::string());
}

std::string FormReader::choice(std::string_view key) {
  const Key& one = row(key);
  const auto* value = std::get_if<std::string>(&one.fallback);
  return object_.choice(key, one.choices, value ? std::optional(*value) : std::nullopt);
}

std::string FormReader::name(std::string_view key, const std::vector<std::string>& names) {
  const bool only_one = !row(key).required && names.size() == 1;
  return object_.choice(key, names, only_one ? std::optional(names.front()) : std::nullopt);
}

std::vector<std::string> FormReader::texts(std::string_view key) {
  (void)row(key);
  return object_.texts(key);
}

Eigen::Vector3d FormReader::vector(std::string_view key, std::optional<Eigen::Vector3d> absent) {
  (void)row(key);
  return object_.vector(key, absent);
}

void FormReader::check_rules() {
  // An empty text says nothing.
  const auto says = [this](const std::string& key) { return has(key) && object_.json()[key] != Json(std::string()); };
  if (!form_.at_least_one.empty() && std::ranges::none_of(form_.at_least_one, says)) {
    std::string keys;
    for (const std::string& key : form_.at_least_one) keys += (keys.empty() ? "'" : ", '") + key + "'";
    diagnostics().error(Code::kMissing, pointer(), fmt::format("none of {} is given", keys), "Give one of them");
  }
  for (const auto& [one, other] : form_.exclusive)
    if (has(one) && has(other))
      diagnostics().error(Code::kConflict, at(one), fmt::format("'{}' beside '{}'", one, other), "Remove one of them");
}

Json schema_of(const Form& form) {
  Json schema, required = Json::array(), properties = Json::object();
  for (const Key& key : form.keys) {
    properties[key.name] = schema_of_key(key);
    if (key.required) required.push_back(key.name);
  }
  if (!form.doc.empty()) schema["description"] = form.doc;
  schema["type"] = "object";
  if (!required.empty()) schema["required"] = required;
  schema["additionalProperties"] = false;
  schema["patternProperties"] = {{R"(^(\$.*|comment)$)", true}};
  schema["properties"] = properties;
  for (const std::string& key : form.at_least_one) schema["anyOf"].push_back({{"required", Json::array({key})}});
  for (const auto& [one, other] : form.exclusive)
    schema["not"]["anyOf"].push_back({{"required", Json::array({one, other})}});
  for (const std::string& definition : form.definitions) schema["allOf"].push_back(reference(definition));
  return schema;
}

Json schema_of_kinds(const std::vector<NamedForm>& kinds, const std::string& key, std::string_view fallback,
                     const std::vector<std::string>& common) {
  Json alternatives = Json::array();
  for (const NamedForm& kind : kinds) {
    Json form = schema_of(kind.form);
    form.erase("type");
    for (const std::string& one : common) form["properties"][one] = true;
    Json chosen{{"properties", {{key, {{"const", kind.name}}}}}};
    if (!fallback.empty() && kind.name != fallback) chosen["required"] = Json::array({key});
    alternatives.push_back({{"if", std::move(chosen)}, {"then", std::move(form)}});
  }
  return alternatives;
}

}  // namespace takt
