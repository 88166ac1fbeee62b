// Objects inside of operations are written by hand in the schema of scenario files: they allow what their tables allow.
// The operations themselves are printed from the tables (schemas/make_schema.py; tests/docs compares).
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/operations/table/operation.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;

const Json& definitions() {
  static const Json schema = Json::parse(std::ifstream("schemas/scenario.schema.json"));
  return schema.at("definitions");
}

/// What a schema allows, wherever below references and alternatives it says so.
struct Allowed {
  std::optional<double> low, high;
  bool low_open = false;
  std::set<std::string> choices;
};
void collect_allowed(const Json& schema, Allowed& allowed) {
  if (schema.contains("$ref")) {
    const std::string name = schema.at("$ref").get<std::string>().substr(std::string("#/definitions/").size());
    if (name != "expression") collect_allowed(definitions().at(name), allowed);
  }
  for (const char* several : {"anyOf", "allOf", "oneOf"})
    for (const Json& one : schema.value(several, Json::array())) collect_allowed(one, allowed);
  if (schema.contains("minimum")) allowed.low = schema.at("minimum").get<double>();
  if (schema.contains("exclusiveMinimum")) allowed.low = schema.at("exclusiveMinimum").get<double>();
  if (schema.contains("exclusiveMinimum")) allowed.low_open = true;
  if (schema.contains("maximum")) allowed.high = schema.at("maximum").get<double>();
  for (const Json& word : schema.value("enum", Json::array()))
    if (word.is_string()) allowed.choices.insert(word.get<std::string>());
}

std::optional<double> bound(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

void expect_same(const ParameterInfo& row, const Json& schema) {
  Allowed allowed;
  collect_allowed(schema, allowed);
  if (row.type == ParameterInfo::Type::kNumber || row.type == ParameterInfo::Type::kInteger) {
    EXPECT_EQ(allowed.low, bound(row.range.low));
    EXPECT_EQ(allowed.high, bound(row.range.high));
    EXPECT_EQ(allowed.low_open, allowed.low && row.range.low_open);
  }
  if (row.type == ParameterInfo::Type::kChoice) {
    EXPECT_EQ(allowed.choices, std::set<std::string>(row.choices.begin(), row.choices.end()));
  }
}

TEST(Operations, ObjectsInTheSchemaAllowWhatTheirTablesAllow) {
  int compared = 0;
  for (const Operation& operation : Operations::global().all()) {
    for (const ParameterInfo& row : operation.parameters()) {
      if (row.refused || row.type != ParameterInfo::Type::kObject) continue;
      // Of objects with several forms the schema has alternatives, and the tables a list of all keys.
      const Json& object = definitions().at(row.definition);
      if (!object.contains("properties")) continue;
      for (const ParameterInfo& field : row.fields) {
        SCOPED_TRACE(row.definition + "." + field.key);
        ASSERT_TRUE(object.at("properties").contains(field.key));
        expect_same(field, object.at("properties").at(field.key));
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 20);
}

}  // namespace
}  // namespace takt::operations
