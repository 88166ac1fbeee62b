#include "core/base/form.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>
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

Json plain(const Key::Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return plain(*number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* truth = std::get_if<bool>(&value)) return *truth;
  if (const auto* texts = std::get_if<std::vector<std::string>>(&value)) return *texts;
  return {};
}

Json reference(const std::string& definition) { return {{"$ref", "#/definitions/" + definition}}; }

const Json& ignored_keys() {
  static const Json pattern{{R"(^(\$.*|comment)$)", true}};
  return pattern;
}

void add_range(const Range& range, Json& schema) {
  if (std::isfinite(range.low)) schema[range.low_open ? "exclusiveMinimum" : "minimum"] = plain(range.low);
  if (std::isfinite(range.high)) schema["maximum"] = plain(range.high);
}

void add_size(const Key& key, Json& schema) {
  const bool members = key.type == Key::Type::kMembers;
  schema["type"] = members ? "object" : "array";
  if (key.min_size > 0) schema[members ? "minProperties" : "minItems"] = key.min_size;
  if (key.max_size > 0) schema[members ? "maxProperties" : "maxItems"] = key.max_size;
}

/// The keys together. An empty text says nothing.
Json all_given(const Form& form, const std::vector<std::string>& keys) {
  Json given{{"required", keys}};
  for (const Key& key : form.keys)
    if (key.type == Key::Type::kText && key.min_size == 0 && std::ranges::find(keys, key.name) != keys.end())
      given["properties"][key.name] = {{"minLength", 1}};
  return given;
}

void add_rule(const Form& form, const Rule& rule, Json& schema) {
  Json alternatives = Json::array();
  for (std::size_t i = 0; i < rule.keys.size(); ++i) {
    if (rule.type != Rule::Type::kAtMostOne) alternatives.push_back({{"required", Json::array({rule.keys[i]})}});
    for (std::size_t k = i + 1; rule.type == Rule::Type::kAtMostOne && k < rule.keys.size(); ++k)
      schema["not"]["anyOf"].push_back(all_given(form, {rule.keys[i], rule.keys[k]}));
  }
  if (rule.type == Rule::Type::kAtLeastOne) schema["anyOf"] = alternatives;
  if (rule.type == Rule::Type::kExactlyOne) schema["oneOf"] = alternatives;
  if (rule.type == Rule::Type::kNeeds) schema["dependencies"][rule.keys[0]].push_back(rule.keys[1]);
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
Key texts_key(std::string name, std::string doc, std::size_t min_size, std::size_t max_size) {
  Key key = list_key(std::move(name), min_size, text_key("", ""), std::move(doc));
  key.max_size = max_size;
  return key;
}
Key pair_key(std::string name, std::string doc) { return texts_key(std::move(name), std::move(doc), 2, 2); }
Key pairs_key(std::string name, std::string doc) {
  return list_key(std::move(name), 0, pair_key("", ""), std::move(doc));
}
Key numbers_key(std::string name, std::size_t count, std::string unit, const Range& range, std::string doc) {
  Key key = number_key(std::move(name), std::move(unit), range, std::move(doc));
  key.type = Key::Type::kNumbers;
  key.min_size = key.max_size = count;
  return key;
}
Key vector_key(std::string name, std::string unit, std::string doc) {
  return numbers_key(std::move(name), 3, std::move(unit), kAnyNumber, std::move(doc));
}
Key object_key(std::string name, Form form, std::string doc) {
  return {.name = std::move(name),
          .type = Key::Type::kObject,
          .doc = std::move(doc),
          .form = std::make_shared<const Form>(std::move(form))};
}
Key list_key(std::string name, std::size_t min_size, Key element, std::string doc) {
  return {.name = std::move(name),
          .type = Key::Type::kList,
          .doc = std::move(doc),
          .min_size = min_size,
          .element = std::make_shared<const Key>(std::move(element))};
}
Key objects_key(std::string name, std::size_t min_size, Form elements, std::string doc) {
  return list_key(std::move(name), min_size, object_key("", std::move(elements), ""), std::move(doc));
}
Key members_key(std::string name, Key element, std::string doc) {
  return {.name = std::move(name),
          .type = Key::Type::kMembers,
          .doc = std::move(doc),
          .element = std::make_shared<const Key>(std::move(element))};
}
Key any_key(std::string name, std::string definition, std::string doc) {
  return {.name = std::move(name), .doc = std::move(doc), .definition = std::move(definition)};
}
Key any_of_key(std::string name, std::vector<std::string> types, std::string doc) {
  return {.name = std::move(name), .doc = std::move(doc), .choices = std::move(types)};
}
std::vector<Key> pose_keys() {
  constexpr Range kPart{.low = -1.001, .high = 1.001};
  return {vector_key("position_m", "m", "[x, y, z].").optional("[0, 0, 0]"),
          vector_key("rpy_deg", "",
                     "[roll, pitch, yaw] in degrees about the fixed x, then y, then z axis; this or 'quaternion'.")
              .optional("no rotation"),
          numbers_key("quaternion", 4, "", kPart, "Unit quaternion [w, x, y, z], norm within 0.001; this or 'rpy_deg'.")
              .optional()};
}
Rule pose_rule() {
  Rule rule = at_most_one({"rpy_deg", "quaternion"});
  rule.told = true;
  return rule;
}

double nanoseconds_in(std::string_view unit) {
  if (unit == "s") return 1e9;
  if (unit == "ms") return 1e6;
  std::fprintf(stderr, "takt: a time in '%.*s'\n", static_cast<int>(unit.size()), unit.data());
  std::abort();
}

Rule at_least_one(std::vector<std::string> keys) { return {Rule::Type::kAtLeastOne, std::move(keys)}; }
Rule at_most_one(std::vector<std::string> keys, std::string hint) {
  return {Rule::Type::kAtMostOne, std::move(keys), std::move(hint)};
}
Rule exactly_one(std::vector<std::string> keys) { return {Rule::Type::kExactlyOne, std::move(keys)}; }
Rule needs(std::string key, std::string other, std::string hint) {
  return {Rule::Type::kNeeds, {std::move(key), std::move(other)}, std::move(hint)};
}

const Key& FormReader::row(std::string_view key) const {
  const auto found = std::ranges::find(form_.keys, key, &Key::name);
  if (found != form_.keys.end()) return *found;
  std::fprintf(stderr, "takt: a form has no key '%.*s'\n", static_cast<int>(key.size()), key.data());
  std::abort();
}

double FormReader::number(std::string_view key, std::optional<double> absent) {
  const Key& one = row(key);
  if (const auto* value = std::get_if<double>(&one.fallback); value && !absent) absent = *value;
  const double value = object_.number(key, absent, one.range);
  if (one.values.empty() || std::ranges::find(one.values, value) != one.values.end()) return value;
  diagnostics().error(Code::kOutOfRange, at(key), fmt::format("unexpected value {:g}", value),
                      fmt::format("Choose one of {}", fmt::join(one.values, ", ")));
  return absent.value_or(one.values.front());
}

double FormReader::number_up_to(std::string_view key, double high, std::optional<double> absent) {
  Range range = row(key).range;
  range.high = high;
  return object_.number(key, absent, range);
}

std::int64_t FormReader::integer(std::string_view key, std::optional<std::int64_t> absent) {
  const Key& one = row(key);
  if (const auto* value = std::get_if<double>(&one.fallback); value && !absent)
    absent = static_cast<std::int64_t>(*value);
  return object_.integer(key, absent, one.range);
}

bool FormReader::boolean(std::string_view key, std::optional<bool> absent) {
  const auto* value = std::get_if<bool>(&row(key).fallback);
  return object_.boolean(key, value && !absent ? std::optional(*value) : absent);
}

std::string FormReader::text(std::string_view key) {
  const Key& one = row(key);
  const auto* value = std::get_if<std::string>(&one.fallback);
  if (one.required || (one.min_size > 0 && has(key))) return object_.text(key);
  return object_.text(key, value ? *value : std::string());
}

std::string FormReader::choice(std::string_view key, std::optional<std::string> absent) {
  const Key& one = row(key);
  const auto* value = std::get_if<std::string>(&one.fallback);
  return object_.choice(key, one.choices, value && !absent ? std::optional(*value) : std::move(absent));
}

std::string FormReader::name(std::string_view key, const std::vector<std::string>& names) {
  const bool only_one = !row(key).required && names.size() == 1;
  return object_.choice(key, names, only_one ? std::optional(names.front()) : std::nullopt);
}

std::vector<std::string> FormReader::texts(std::string_view key) {
  const Key& one = row(key);
  const bool may_lack = !one.required && !has(key);
  std::vector<std::string> list =
      object_.texts(key, may_lack ? std::optional(std::vector<std::string>()) : std::nullopt);
  if (!has(key) || !object_.json()[key].is_array()) return list;
  const std::size_t size = object_.json()[key].size(), most = one.max_size > 0 ? one.max_size : size;
  if (size < one.min_size || size > most) {
    diagnostics().error(Code::kWrongSize, at(key), fmt::format("{} texts", size),
                        one.min_size == most  ? fmt::format("Give {}", most)
                        : size < one.min_size ? fmt::format("Give at least {}", one.min_size)
                                              : fmt::format("Give at most {}", most));
  }
  return list;
}

std::vector<double> FormReader::numbers(std::string_view key, std::optional<std::vector<double>> absent) {
  const Key& one = row(key);
  return object_.numbers(key, one.min_size == one.max_size ? one.min_size : 0, std::move(absent), one.range);
}

Eigen::Vector3d FormReader::vector(std::string_view key, std::optional<Eigen::Vector3d> absent) {
  std::optional<std::vector<double>> values;
  if (absent) values = {absent->x(), absent->y(), absent->z()};
  return Eigen::Vector3d(numbers(key, std::move(values)).data());
}

std::optional<NamedForm> FormReader::kind() {
  const Kinds& kinds = *form_.kinds;
  const std::vector<NamedForm> forms = kinds.forms();
  const auto* fallback = std::get_if<std::string>(&kinds.key.fallback);
  if (!kinds.key.required && fallback == nullptr && !has(kinds.key.name)) {
    (void)object_.child(kinds.key.name);
    return {};
  }
  std::vector<std::string> names;
  for (const NamedForm& form : forms) names.emplace_back(form.name);
  const std::string word = object_.choice(kinds.key.name, names, fallback ? std::optional(*fallback) : std::nullopt);
  for (const NamedForm& form : forms)
    if (form.name == word) return form;
  return {};
}

const Json* FormReader::json(std::string_view key) {
  const Key& one = row(key);
  if (one.type == Key::Type::kList) return object_.array(key, one.required);
  if (one.type != Key::Type::kAny || one.choices == std::vector<std::string>{"object"})
    return object_.object(key, one.required);
  const Json* value = object_.child(key);
  if (value == nullptr && one.required)
    diagnostics().error(Code::kMissing, pointer(), fmt::format("key '{}' is missing", key), "Give a value");
  return value;
}

void FormReader::members(std::string_view key,
                         const std::function<void(const std::string&, const Json&, const std::string&)>& read) {
  const Key& one = row(key);
  const Json* all = json(key);
  if (all == nullptr) return;
  check_size(one, *all);
  for (const auto& [name, value] : all->items()) {
    if (one.comments && (name.starts_with("$") || name == "comment")) continue;
    const std::string place = at(key) + pointer_segment(name);
    if (one.names != nullptr && !one.names->allows(name)) {
      diagnostics().error(Code::kInvalidName, place,
                          name.empty() ? "an empty name" : fmt::format("invalid name '{}'", name), one.names->hint);
    }
    read(name, value, place);
  }
}

void FormReader::check_size(const Key& key, const Json& all) {
  const std::size_t least = key.min_size, most = key.max_size;
  if (most > 0 && all.size() > most)
    diagnostics().error(Code::kWrongSize, at(key.name), fmt::format("{} entries", all.size()),
                        fmt::format("Give at most {}", most));
  if (all.size() < least)
    diagnostics().error(least == 1 ? Code::kMissing : Code::kWrongSize, at(key.name),
                        fmt::format("{} entries", all.size()), fmt::format("Give at least {}", least));
}

void FormReader::elements(std::string_view key, const std::function<void(const Json&, const std::string&)>& read) {
  const Json* all = json(key);
  if (all == nullptr) return;
  check_size(row(key), *all);
  for (std::size_t i = 0; i < all->size(); ++i) read((*all)[i], at(key) + pointer_segment(i));
}

void FormReader::check_rules() {
  const auto says = [this](const std::string& key) { return has(key) && object_.json()[key] != Json(std::string()); };
  for (const Rule& rule : form_.rules) {
    if (rule.told) continue;
    if (rule.type == Rule::Type::kNeeds) {
      if (says(rule.keys[0]) && !says(rule.keys[1]))
        diagnostics().error(Code::kMissing, at(rule.keys[0]),
                            fmt::format("'{}' without '{}'", rule.keys[0], rule.keys[1]),
                            rule.hint.empty() ? "Give both, or none" : rule.hint);
      continue;
    }
    std::vector<std::string> given;
    std::ranges::copy_if(rule.keys, std::back_inserter(given), says);
    if (given.empty() && rule.type != Rule::Type::kAtMostOne)
      diagnostics().error(Code::kMissing, pointer(), fmt::format("none of '{}' is given", fmt::join(rule.keys, "', '")),
                          "Give one of them");
    if (given.size() > 1 && rule.type != Rule::Type::kAtLeastOne)
      diagnostics().error(Code::kConflict, rule.type == Rule::Type::kExactlyOne ? pointer() : at(given[0]),
                          fmt::format("'{}' beside '{}'", given[0], given[1]),
                          rule.hint.empty() ? "Remove one of them" : rule.hint);
  }
}

void SchemaWriter::add_type(const Key& key, Json& schema) {
  using Type = Key::Type;
  switch (key.type) {
    case Type::kNumber:
    case Type::kInteger:
      schema["type"] = key.type == Type::kNumber ? "number" : "integer";
      add_range(key.range, schema);
      for (const double value : key.values) schema["enum"].push_back(plain(value));
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
    case Type::kNumbers:
      add_size(key, schema);
      schema["items"]["type"] = "number";
      return add_range(key.range, schema["items"]);
    case Type::kObject:
      return schema.update(reference_to(*key.form));
    case Type::kList:
      add_size(key, schema);
      schema["items"] = schema_of(*key.element);
      return;
    case Type::kMembers:
      add_size(key, schema);
      if (key.names != nullptr) schema["propertyNames"]["pattern"] = key.names->pattern;
      if (key.comments) schema["patternProperties"] = ignored_keys();
      schema["additionalProperties"] = schema_of(*key.element);
      return;
    case Type::kAny:
      if (!key.choices.empty()) schema["type"] = key.choices;
      return;
  }
}

Json SchemaWriter::schema_of(const Key& key) {
  Json schema = Json::object();
  if (key.definition.empty()) {
    add_type(key, schema);
  } else {
    schema = reference(key.definition);
  }
  if (key.or_parameter) schema = {{"anyOf", Json::array({schema, {{"type", "string"}, {"pattern", R"(^\$)"}}})}};
  if (key.doc.empty()) return schema.empty() ? Json(true) : schema;
  // Beside a reference draft-07 ignores every other key, the description too.
  if (schema.contains("$ref")) schema = {{"allOf", Json::array({schema})}};
  if (Json value = plain(key.fallback); !value.is_null()) schema["default"] = std::move(value);
  schema["description"] = description_of(key);
  return schema;
}

Json SchemaWriter::reference_to(const Form& form) {
  if (form.definition.empty()) return schema_of(form);
  if (!definitions_.contains(form.definition)) {
    definitions_[form.definition] = true;  // it may refer to itself
    Json schema = schema_of(form);
    definitions_[form.definition] = std::move(schema);
  }
  return reference(form.definition);
}

Json SchemaWriter::schema_of(const Form& form) {
  Json schema, required = Json::array(), properties = Json::object();
  for (const Key& key : form.keys) {
    properties[key.name] = schema_of(key);
    if (key.required) required.push_back(key.name);
  }
  if (!form.doc.empty()) schema["description"] = form.doc;
  schema["type"] = "object";
  if (form.kinds && form.kinds->key.required) required.push_back(form.kinds->key.name);
  if (!required.empty()) schema["required"] = required;
  if (!form.kinds) {
    if (form.others) schema["additionalProperties"] = schema_of(*form.others);
    if (!form.others) schema["additionalProperties"] = false;
    schema["patternProperties"] = ignored_keys();
  }
  schema["properties"] = properties;
  if (form.kinds) add_kinds(form, schema);
  for (const Rule& rule : form.rules) add_rule(form, rule, schema);
  return schema;
}

void SchemaWriter::add_kinds(const Form& form, Json& schema) {
  Key choice = form.kinds->key;
  const auto* fallback = std::get_if<std::string>(&choice.fallback);
  const auto add_keys = [&](Json kind) {
    kind.erase("type");
    for (const Key& key : form.keys) kind["properties"][key.name] = true;
    kind["properties"][choice.name] = true;
    return kind;
  };
  for (const NamedForm& kind : form.kinds->forms()) {
    choice.choices.emplace_back(kind.name);
    Json chosen{{"properties", {{choice.name, {{"const", kind.name}}}}}};
    if (fallback == nullptr || kind.name != *fallback) chosen["required"] = Json::array({choice.name});
    schema["allOf"].push_back({{"if", std::move(chosen)}, {"then", add_keys(schema_of(kind.form))}});
  }
  if (!choice.required && fallback == nullptr)
    schema["allOf"].push_back(
        {{"if", {{"not", {{"required", Json::array({choice.name})}}}}}, {"then", add_keys(schema_of(Form{}))}});
  schema["properties"][choice.name] = schema_of(choice);
}

Json schema_of(const Form& form) {
  Json unused = Json::object();
  return SchemaWriter(unused).schema_of(form);
}

}  // namespace takt
