// The published schema says what the reader says about the form of a net.
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "core/base/json.h"
#include "tests/core/net/random_net.h"

namespace takt::net {
namespace {

using Adapter = valijson::adapters::NlohmannJsonAdapter;

class Schema {
 public:
  Schema() {
    std::ifstream file("schemas/net.schema.json");
    const auto json = nlohmann::json::parse(file);
    valijson::SchemaParser parser;
    parser.populateSchema(Adapter(json), schema_);
  }
  [[nodiscard]] bool takes(const std::string& text) const {
    const auto json = nlohmann::json::parse(text);
    valijson::Validator validator;
    return validator.validate(schema_, Adapter(json), nullptr);
  }

 private:
  valijson::Schema schema_;
};

TEST(NetSchema, TakesEveryNetThatIsWritten) {
  const Schema schema;
  for (int seed = 0; seed < 100; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "schema");
    EXPECT_TRUE(schema.takes(net_to_json(random_net(random, 25)).dump())) << seed;
  }
}

TEST(NetSchema, RefusesWhatTheReaderRefuses) {
  const Schema schema;
  const char* kTexts[] = {
      R"({"primitives": [{"id": "a"}]})",
      R"({"primitives": [{"id": "a", "type": "T", "x": 1}]})",
      R"({"primitives": {}})",
      R"({"links": [{"from": "a.b"}]})",
      R"({"links": [{"from": "a.b", "to": "c.d", "delayed": 1}]})",
      R"({"fragments": [{"id": "f"}]})",
      R"({"fragments": [{"id": "f", "net": {}, "when_inactive": "rest"}]})",
      R"({"fragments": [{"id": "f", "net": {}, "inputs": [{"port": "p"}]}]})",
      R"({"nmae": "x"})",
      R"({"demands": {}})",
      R"({"demands": [{"from": "a.b", "to": "c.d"}]})",
      R"({"demands": [{"from": "a.b", "to": "c.d", "maximum_cycles": -1}]})",
      R"({"demands": [{"from": "a.b", "to": "c.d", "maximum_cycles": 0.5}]})",
      R"({"demands": [{"from": "a.b", "to": "c.d", "maximum_cycles": 1, "max": 1}]})",
      R"({"primitives": [{"id": "a", "type": "T", "on_null": true}]})",
      R"([])",
  };
  for (const char* text : kTexts) {
    EXPECT_FALSE(schema.takes(text)) << text;
    EXPECT_FALSE(net_from_json(*parse_json(text)).has_value()) << text;
  }
}

}  // namespace
}  // namespace takt::net
