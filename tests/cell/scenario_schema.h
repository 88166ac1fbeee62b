#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "core/device/device_file.h"
#include "tests/cell/described.h"

/// The schema of scenario files, and mistakes to try it with.
namespace takt::cell::test {

using Json = nlohmann::json;

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class ScenarioSchema {
 public:
  ScenarioSchema() {
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(valijson::adapters::NlohmannJsonAdapter(text_), schema_);
  }
  bool accepts(const Json& json) const {
    return valijson::Validator().validate(schema_, valijson::adapters::NlohmannJsonAdapter(json), nullptr);
  }

 private:
  Json text_ = Json::parse(text_of("schemas/scenario.schema.json"));
  valijson::Schema schema_;
};

inline const ScenarioSchema& schema() {
  static const ScenarioSchema schema;
  return schema;
}

/// One mistake in a file: `value` at `pointer`; null: what stands there is taken out.
struct Mistake {
  const char* pointer;
  const char* value;
};

inline void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.pointer << " = " << (mistake.value ? mistake.value : "nothing");
}

inline Json with_mistake(Json json, const Mistake& mistake) {
  const Json::json_pointer pointer(mistake.pointer);
  if (mistake.value) {
    json[pointer] = Json::parse(mistake.value);
  } else {
    json[pointer.parent_pointer()].erase(pointer.back());
  }
  return json;
}

}  // namespace takt::cell::test
