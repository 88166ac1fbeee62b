// A form of a file is read and printed by the same rows (docs/tables.md).
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/form.h"

namespace takt::form_test {
namespace {

using Json = nlohmann::ordered_json;

Form cup_form() {
  return {"A cup.",
          {number_key("volume_m3", "m3", kPositive, "Volume."),
           number_key("angle_deg", "degrees", kAnyNumber, "Angle.").by_default(30.0),
           integer_key("handles", kNotNegative, "Handles.").by_default(1.0),
           choice_key("of", {"clay", "tin"}, "Material.").by_default("clay"),
           text_key("label", "Label.", 1).optional("none"), text_key("owner", "Owner.").optional("the only one"),
           boolean_key("hot", "Hot.").optional(), boolean_key("cold", "Cold.").optional(),
           pair_key("between", "Two hands.").optional(), any_key("at", "place", "").optional()},
          {at_least_one({"label", "owner"}), at_most_one({"hot", "cold"})}};
}

/// The codes and pointers of all that is wrong.
std::vector<std::string> diagnostics_of(const Json& json) {
  Diagnostics diagnostics;
  ObjectReader object(json, "/cup", diagnostics);
  const Form form = cup_form();
  FormReader from(form, object);
  (void)from.number("volume_m3");
  (void)from.number("angle_deg");
  (void)from.integer("handles");
  (void)from.choice("of");
  (void)from.text("label");
  (void)from.name("owner", {"Ann", "Bob"});
  for (const char* key : {"hot", "cold"})
    if (from.has(key)) (void)from.boolean(key);
  if (from.has("between")) (void)from.texts("between");
  (void)from.object().child("at");
  from.check_rules();
  object.finish();
  std::vector<std::string> list;
  for (const Diagnostic& one : diagnostics.list()) list.push_back(std::string(name_of(one.code)) + " " + one.pointer);
  return list;
}

TEST(Form, GivesWhatTheRowsSay) {
  const Json json = Json::parse(R"({"volume_m3": 2, "label": "x"})");
  Diagnostics diagnostics;
  ObjectReader object(json, "", diagnostics);
  const Form form = cup_form();
  FormReader from(form, object);
  EXPECT_EQ(from.number("volume_m3"), 2.0);
  EXPECT_EQ(from.number("angle_deg"), 30.0);
  EXPECT_EQ(from.integer("handles"), 1);
  EXPECT_EQ(from.choice("of"), "clay");
  EXPECT_EQ(from.text("label"), "x");
  EXPECT_EQ(from.name("owner", {"Ann"}), "Ann") << "the only one";
  from.check_rules();
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
}

TEST(Form, SaysAllThatIsWrong) {
  using List = std::vector<std::string>;
  EXPECT_EQ(diagnostics_of(Json::parse(R"({"volume_m3": 1, "label": "x", "owner": "Ann"})")), List());
  EXPECT_EQ(diagnostics_of(Json::parse(R"({"volume_m3": 1, "owner": "Ann", "label": "", "hot": true, "cold": false})")),
            List({"wrong-type /cup/label", "conflict /cup/hot"}));
  EXPECT_EQ(diagnostics_of(Json::parse(R"({"label": "x", "owner": "Cay", "of": "gold", "handles": -1, "hoot": true})"))
                .size(),
            5u);
}

TEST(Form, IsPrintedAsASchema) {
  const Json schema = schema_of(cup_form());
  const auto at = [&](const std::string& key) { return schema["properties"][key]; };
  EXPECT_EQ(schema["required"], Json::array({"volume_m3"}));
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(at("volume_m3"), Json::parse(R"({"type": "number", "exclusiveMinimum": 0, "description": "Volume, m3."})"));
  EXPECT_EQ(at("angle_deg")["default"], 30);
  EXPECT_EQ(at("of"), Json::parse(R"({"enum": ["clay", "tin"], "default": "clay", "description": "Material."})"));
  EXPECT_EQ(at("label"), Json::parse(R"({"type": "string", "minLength": 1, "description": "Label; default: none."})"));
  EXPECT_EQ(at("at"), Json::parse(R"({"$ref": "#/definitions/place"})"));
  EXPECT_EQ(schema["anyOf"], Json::parse(R"([{"required": ["label"]}, {"required": ["owner"]}])"));
  EXPECT_EQ(schema["not"], Json::parse(R"({"anyOf": [{"required": ["hot", "cold"]}]})"));
}

TEST(FormDeathTest, AKeyWithoutARowIsAProgrammingError) {
  const Json json = Json::object();
  Diagnostics diagnostics;
  ObjectReader object(json, "", diagnostics);
  const Form form = cup_form();
  FormReader from(form, object);
  EXPECT_DEATH((void)from.number("saucer"), "saucer");
}

}  // namespace
}  // namespace takt::form_test
