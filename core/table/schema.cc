#include "core/table/schema.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::table {
namespace {

using Json = nlohmann::ordered_json;
using Type = Field::Type;

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();
constexpr const char* kIgnoredKeys = R"(^(\$.*|comment)$)";

Json number_schema(const char* type, const Range& range) {
  Json schema{{"type", type}};
  if (std::isfinite(range.low)) schema[range.low_open ? "exclusiveMinimum" : "minimum"] = plain_number(range.low);
  if (std::isfinite(range.high)) schema["maximum"] = plain_number(range.high);
  return schema;
}

Json array_of(Json items, const Count& count) {
  Json schema{{"type", "array"}};
  if (count.min > 0) schema["minItems"] = count.min;
  if (count.max != kNoLimit) schema["maxItems"] = count.max;
  if (!items.is_null()) schema["items"] = std::move(items);
  return schema;
}

/// A text that has to be there names something, so it is not empty.
Json text_schema(const Field& field) {
  Json schema{{"type", "string"}};
  if (field.count.min > 0 || field.required) schema["minLength"] = 1;
  if (!field.pattern.empty()) schema["pattern"] = field.pattern;
  return schema;
}

Json required(const std::vector<std::string>& keys) { return {{"required", keys}}; }

Json any_of(Json schemas) { return schemas.size() == 1 ? schemas.front() : Json{{"anyOf", std::move(schemas)}}; }

Json all_required(const std::vector<std::vector<std::string>>& groups) {
  Json list = Json::array();
  for (const auto& group : groups) list.push_back(required(group));
  return list;
}

/// Each pair of groups that may not be given together.
void add_exclusions(const Rule& rule, Json& excluded) {
  for (std::size_t i = 0; i < rule.groups.size(); ++i) {
    for (std::size_t k = i + 1; k < rule.groups.size(); ++k) {
      std::vector<std::string> both = rule.groups[i];
      both.insert(both.end(), rule.groups[k].begin(), rule.groups[k].end());
      excluded.push_back(required(both));
    }
  }
}

void add_dependency(const Rule& rule, Json& schema, Json& all) {
  if (rule.groups[0].size() == 1) {
    for (const std::string& needed : rule.groups[1]) schema["dependencies"][rule.groups[0].front()].push_back(needed);
  } else {
    all.push_back({{"if", required(rule.groups[0])}, {"then", required(rule.groups[1])}});
  }
}

/// @param all  what goes into "allOf"
void add_rules(const std::vector<Rule>& rules, Json& schema, Json& all) {
  Json excluded = Json::array();
  for (const Rule& rule : rules) {
    switch (rule.kind) {
      case Rule::Kind::kOneOf:
        all.push_back({{"oneOf", all_required(rule.groups)}});
        break;
      case Rule::Kind::kAnyOf:
        all.push_back({{"anyOf", all_required(rule.groups)}});
        break;
      case Rule::Kind::kNotTogether:
        add_exclusions(rule, excluded);
        break;
      case Rule::Kind::kNeeds:
        add_dependency(rule, schema, all);
        break;
    }
  }
  if (!excluded.empty()) schema["not"] = any_of(std::move(excluded));
}

/// One demand of "allOf" needs no list.
void add_all(Json all, Json& schema) {
  if (all.size() == 1 && !schema.contains(all.front().begin().key())) {
    schema.update(all.front());
  } else if (!all.empty()) {
    schema["allOf"] = std::move(all);
  }
}

Json is_word(const Field& choice, const std::string& word) {
  Json when{{"properties", {{choice.key, {{"const", word}}}}}};
  if (choice.fallback != word) when["required"] = Json::array({choice.key});
  return when;
}

const Field& choice_of(const Field& object) {
  return *std::ranges::find(object.fields, object.discriminator, &Field::key);
}

}  // namespace

Json reference_to(std::string_view definition) { return {{"$ref", fmt::format("#/definitions/{}", definition)}}; }

Json plain_number(double value) {
  constexpr double kMostWhole = 1e15;
  if (std::trunc(value) == value && std::abs(value) < kMostWhole) return static_cast<std::int64_t>(value);
  return value;
}

SchemaPrinter::SchemaPrinter(In in) : in_(in), definitions_(std::make_unique<Json>(Json::object())) {}
SchemaPrinter::~SchemaPrinter() = default;

void SchemaPrinter::define(const std::string& name, Json schema) { (*definitions_)[name] = std::move(schema); }

bool SchemaPrinter::takes_expressions(const Field& field) const {
  if (in_ == In::kFile || field.literal) return false;
  return field.type == Type::kNumber || field.type == Type::kInteger || field.type == Type::kBoolean ||
         field.type == Type::kChoice || field.type == Type::kTexts || field.type == Type::kNumbers;
}

Json SchemaPrinter::value_of(const Field& field) {
  switch (field.type) {
    case Type::kBoolean:
      return {{"type", "boolean"}};
    case Type::kInteger:
      return number_schema("integer", field.range);
    case Type::kNumber:
      return number_schema("number", field.range);
    case Type::kNumbers: {
      Json number = number_schema("number", field.range);
      if (takes_expressions(field)) number = {{"anyOf", {reference_to("expression"), std::move(number)}}};
      return array_of(std::move(number), field.count);
    }
    case Type::kVector:
      if (in_ == In::kProgram && !field.literal) return reference_to("program_vector");
      return array_of(number_schema("number", field.range), {.min = 3, .max = 3});
    case Type::kText:
    case Type::kName:
      return text_schema(field);
    case Type::kTexts:
      return array_of({{"type", "string"}}, field.count);
    case Type::kChoice:
      return field.choices.size() == 1 ? Json{{"const", field.choices.front()}} : Json{{"enum", field.choices}};
    case Type::kCondition:
      return reference_to(field.definition);
    case Type::kObject:
    case Type::kList:
    case Type::kMap:
    case Type::kEither:
    case Type::kAny:
      return field.definition.empty() ? body_of(field) : refer_to(field);
  }
  return {};
}

/// A reference, and the definition if it is the first one. It is entered before it is printed: it may name itself.
Json SchemaPrinter::refer_to(const Field& field) {
  define(field);
  return reference_to(field.definition);
}

void SchemaPrinter::define(const Field& field) {
  if (definitions_->contains(field.definition)) return;
  if (std::ranges::find(left_out_, field.definition) != left_out_.end()) return;
  const Field& form = field.form != nullptr ? field.form() : field;
  (*definitions_)[field.definition] = Json();
  Json body = body_of(form);
  if (field.form != nullptr && !form.doc.empty()) {
    Json described{{"description", form.doc}};
    described.update(body);
    body = std::move(described);
  }
  (*definitions_)[field.definition] = std::move(body);
}

Json SchemaPrinter::body_of(const Field& field) {
  switch (field.type) {
    case Type::kObject:
      return field.variants.empty() || field.variants.front().definition.empty() ? object_of(field)
                                                                                 : choose_kind(field);
    case Type::kList:
      return array_of(of(field.items.front()), field.count);
    case Type::kMap: {
      Json schema{{"type", "object"}};
      if (!field.pattern.empty()) schema["propertyNames"] = {{"pattern", field.pattern}};
      schema["additionalProperties"] = of(field.items.front());
      if (field.any_key) schema["patternProperties"] = {{kIgnoredKeys, true}};
      return schema;
    }
    case Type::kEither: {
      Json forms = Json::array();
      for (const Field& one : field.items) forms.push_back(of(one));
      return {{"anyOf", std::move(forms)}};
    }
    case Type::kAny:
      return Json::object();
    default:
      return value_of(field);
  }
}

Json SchemaPrinter::object_of(const Field& object) {
  if (object.any_key && object.fields.empty()) return {{"type", "object"}};
  Json schema{{"type", "object"}}, needed = Json::array(), properties = Json::object(), all = Json::array();
  for (const Field& one : object.fields) {
    if (one.refused) continue;
    properties[one.key] = one.doc.empty() && one.type == Type::kAny ? Json(true) : of(one);
    if (one.required) needed.push_back(one.key);
  }
  if (!object.variants.empty()) add_variants(object, properties, all);
  if (!needed.empty()) schema["required"] = std::move(needed);
  if (!object.any_key) {
    schema["additionalProperties"] = false;
    schema["patternProperties"] = {{kIgnoredKeys, true}};
  }
  schema["properties"] = std::move(properties);
  add_rules(object.rules, schema, all);
  add_all(std::move(all), schema);
  return schema;
}

/// The keys of all variants beside the common ones; which of them there may be depends on the discriminator.
void SchemaPrinter::add_variants(const Field& object, Json& properties, Json& all) {
  std::map<std::string, std::vector<Json>> forms;
  std::vector<std::string> keys;
  for (const Field& variant : object.variants) {
    for (const Field& one : variant.fields) {
      if (!forms.contains(one.key)) keys.push_back(one.key);
      Json form = of(one);
      auto& known = forms[one.key];
      if (std::ranges::find(known, form) == known.end()) known.push_back(std::move(form));
    }
  }
  for (const std::string& key : keys)
    properties[key] = forms[key].size() == 1 ? forms[key].front() : Json{{"anyOf", forms[key]}};
  const auto demand = [&](const std::vector<Field>& fields, const std::vector<Rule>& rules) {
    Json then = Json::object(), own = Json::object(), inner = Json::array(), needed = Json::array();
    for (const std::string& key : keys) {
      const auto found = std::ranges::find(fields, key, &Field::key);
      if (found == fields.end()) {
        own[key] = false;
      } else if (forms[key].size() > 1) {
        own[key] = of(*found);
      }
    }
    for (const Field& one : fields)
      if (one.required) needed.push_back(one.key);
    if (!needed.empty()) then["required"] = std::move(needed);
    if (!own.empty()) then["properties"] = std::move(own);
    add_rules(rules, then, inner);
    add_all(std::move(inner), then);
    return then;
  };
  const Field& choice = choice_of(object);
  for (const Field& variant : object.variants)
    all.push_back({{"if", is_word(choice, variant.key)}, {"then", demand(variant.fields, variant.rules)}});
  if (!choice.required && choice.fallback.empty())
    all.push_back({{"if", {{"not", required({object.discriminator})}}}, {"then", demand({}, {})}});
}

/// A registry: each kind is a definition of its own.
Json SchemaPrinter::choose_kind(const Field& object) {
  Json chosen = Json::array();
  const Field& choice = choice_of(object);
  for (const Field& kind : object.variants) {
    Field whole = kind;
    whole.type = Type::kObject;
    whole.fields = object.fields;
    *std::ranges::find(whole.fields, object.discriminator, &Field::key) = field(choice.key, Type::kAny, "");
    whole.fields.insert(whole.fields.end(), kind.fields.begin(), kind.fields.end());
    whole.rules.insert(whole.rules.end(), object.rules.begin(), object.rules.end());
    Json body{{"description", kind.doc}};
    body.update(object_of(whole));
    define(kind.definition, std::move(body));
    chosen.push_back({{"if", is_word(choice, kind.key)}, {"then", reference_to(kind.definition)}});
  }
  Json schema{{"type", "object"}};
  if (choice.required) schema["required"] = Json::array({object.discriminator});
  schema["properties"] = {{object.discriminator, of(choice)}};
  schema["allOf"] = std::move(chosen);
  return schema;
}

Json SchemaPrinter::of(const Field& field) {
  Json schema = Json::object();
  if (!field.doc.empty()) {
    schema["description"] =
        field.fallback.empty() ? field.doc : fmt::format("{} Default: {}.", field.doc, field.fallback);
  }
  Json value = value_of(field);
  if (field.or_parameter) value = {{"anyOf", {std::move(value), {{"type", "string"}, {"pattern", "^\\$"}}}}};
  if (takes_expressions(field)) {
    schema["anyOf"] = {reference_to("expression"), std::move(value)};
  } else if (value.contains("$ref") && !schema.empty()) {
    // Beside a reference draft-07 ignores every other key, the description too.
    schema["allOf"] = Json::array({std::move(value)});
  } else {
    schema.update(value);
  }
  return schema;
}

Json SchemaPrinter::in(In in, const Field& field) {
  const In before = std::exchange(in_, in);
  Json schema = of(field);
  in_ = before;
  return schema;
}

}  // namespace takt::table
