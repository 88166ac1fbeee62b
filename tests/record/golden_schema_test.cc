#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "record/golden.h"
#include "tests/record/support.h"

namespace takt::record {
namespace {

bool fits_schema(const nlohmann::json& json) {
  std::ifstream in("schemas/golden.schema.json");
  const nlohmann::json text = nlohmann::json::parse(in);
  valijson::Schema schema;
  valijson::SchemaParser(valijson::SchemaParser::kDraft7)
      .populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
  return valijson::Validator().validate(schema, valijson::adapters::NlohmannJsonAdapter(json), nullptr);
}

TEST(GoldenSchema, WhatBlessWritesFitsAndAForeignKeyDoesNot) {
  TestFolder folder("schema");
  record_run(folder / "a.mcap", 100);
  BlessOptions options;
  options.scenario = "touch";
  options.reason = "watched";
  const Golden golden = make_golden(Recording::open(folder / "a.mcap").value(), options).value();
  nlohmann::json json = nlohmann::json::parse(golden_to_text(golden));
  EXPECT_TRUE(fits_schema(json));
  json["columns"][3]["tolerence"] = 1;
  EXPECT_FALSE(fits_schema(json));
}

}  // namespace
}  // namespace takt::record
