// The schema of scenario files and the tables of parameters name the same keys, both ways.
#include <fstream>
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

}  // namespace
}  // namespace takt::activity
