// The schema of scenario files and the tables of parameters name the same keys, both ways.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/operations/operation.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

const Json& definitions() {
  static const Json schema = Json::parse(std::ifstream("schemas/scenario.schema.json"));
  return schema.at("definitions");
}

/// Keys of the properties of one definition, without those that every operation has.
std::set<std::string> keys_in_schema(const std::string& definition) {
  std::set<std::string> keys;
  for (const auto& [key, value] : definitions().at(definition).at("properties").items()) keys.insert(key);
  for (const char* shared : {"do", "name", "start", "on"}) keys.erase(shared);
  return keys;
}

TEST(Operations, TheSchemaHasTheKeysOfTheTables) {
  for (const Operation& operation : Operations::global().all()) {
    if (operation.name == "transaction") continue;  // 'on' is a key of its own there
    const std::string definition = operation.name == "net" ? "net_step" : std::string(operation.name);
    std::set<std::string> in_table;
    for (const ParameterInfo& one : operation.parameters()) {
      if (!one.refused) in_table.insert(one.key);
    }
    EXPECT_EQ(in_table, keys_in_schema(definition)) << operation.name;
  }
}

TEST(Operations, TheSchemaRequiresWhatTheTablesRequire) {
  for (const Operation& operation : Operations::global().all()) {
    const std::string definition = operation.name == "net" ? "net_step" : std::string(operation.name);
    const Json required = definitions().at(definition).value("required", Json::array());
    for (const Json& key : required) {
      const auto& parameters = operation.parameters();
      const auto found = std::ranges::find(parameters, key.get<std::string>(), &ParameterInfo::key);
      ASSERT_NE(found, parameters.end()) << operation.name << "." << key;
      EXPECT_TRUE(found->required || found->fallback.starts_with("the only")) << operation.name << "." << key;
    }
  }
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

TEST(Operations, TheSchemaAllowsWhatTheTablesAllow) {
  for (const Operation& operation : Operations::global().all()) {
    const std::string definition = operation.name == "net" ? "net_step" : std::string(operation.name);
    const Json& properties = definitions().at(definition).at("properties");
    for (const ParameterInfo& row : operation.parameters()) {
      if (row.refused) continue;
      SCOPED_TRACE(definition + "." + row.key);
      expect_same(row, properties.at(row.key));
      // Objects with one form; those with several are read by hand.
      const Json object = definitions().value(row.definition, Json::object());
      if (row.type != ParameterInfo::Type::kObject || !object.contains("properties")) continue;
      for (const ParameterInfo& field : row.fields) {
        SCOPED_TRACE(row.definition + "." + field.key);
        ASSERT_TRUE(object.at("properties").contains(field.key));
        expect_same(field, object.at("properties").at(field.key));
      }
    }
  }
}

}  // namespace
}  // namespace takt::activity
