// A form whose rows say which member they fill is read, checked and printed by them (docs/tables.md).
#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/form_of.h"

namespace takt::form_of_test {
namespace {

using Json = nlohmann::ordered_json;
using testing::ElementsAre;

struct Lid {
  double width = 0.0;
  std::optional<double> mass;
  friend bool operator==(const Lid&, const Lid&) = default;
};
struct Handle {
  std::string name;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};
struct Pot {
  enum class Heat { kNone, kGas, kCurrent };
  std::int64_t count = 2;
  Nanoseconds time = 5 * kMillisecond;
  bool hot = false;
  std::string label = "pot";
  std::optional<Lid> lid;
  std::vector<Lid> spare;
  std::vector<Handle> handles;
  std::map<std::string, Lid, std::less<>> by_colour;
  Heat heat = Heat::kNone;
  double pressure = 0.0;
};

const NameRule kShort{.pattern = "^.{1,5}$",
                      .allows = [](std::string_view name) { return !name.empty() && name.size() <= 5; },
                      .hint = "Choose a short name"};

const FormOf<Lid>& lid_form() {
  static const auto form = FormOf<Lid>("lid", "A lid.")
                               .add(number_key("width_m", "m", kPositive, "Width."), &Lid::width)
                               .add(number_key("mass_kg", "kg", kPositive, "Mass.").optional(), &Lid::mass);
  return form;
}
const FormOf<Handle>& handle_form() {
  static const auto form = FormOf<Handle>().pose(&Handle::X);
  return form;
}
const FormOf<Pot>& pot_form() {
  using Heat = Pot::Heat;
  static const auto form =
      FormOf<Pot>("", "A pot.")
          .add(integer_key("count", {.low = 1, .high = 9}, "How many.").optional(), &Pot::count)
          .add(number_key("time_ms", "ms", kNotNegative, "Time.").with_values({5, 10}).optional(), &Pot::time)
          .add(boolean_key("hot", "Hot.").optional(), &Pot::hot)
          .add(text_key("label", "Label.").optional(), &Pot::label)
          .add(object_key("lid", lid_form(), "Its lid.").optional(), &Pot::lid)
          .add(objects_key("spare", 1, lid_form(), "Other lids.").optional(), &Pot::spare)
          .add(members_key("handles", kShort, handle_form(), "Handles by name.").optional(), &Pot::handles)
          .add(members_key("by_colour", kShort, lid_form(), "Lids by colour.").optional(), &Pot::by_colour)
          .rule(needs("hot", "lid"))
          .kinds(choice_key("heat", {}, "By what.").by_default("none"), &Pot::heat,
                 FormOf<Pot>::KindList<Heat>{
                     {"none", Heat::kNone, FormOf<Pot>()},
                     {"gas", Heat::kGas,
                      FormOf<Pot>().add(number_key("pressure_bar", "bar", kPositive, "Of the gas."), &Pot::pressure)}});
  return form;
}

Pot read(const char* text, Diagnostics& diagnostics) { return pot_form().read(Json::parse(text), "/pot", diagnostics); }

/// Codes and pointers of all that is wrong.
std::vector<std::string> diagnostics_of(const char* text) {
  Diagnostics diagnostics;
  (void)read(text, diagnostics);
  std::vector<std::string> list;
  for (const Diagnostic& one : diagnostics.list()) list.push_back(std::string(name_of(one.code)) + " " + one.pointer);
  return list;
}

TEST(FormOf, FillsTheMembersOfItsRows) {
  Diagnostics diagnostics;
  const Pot pot = read(R"({"count": 3, "time_ms": 10, "hot": true, "label": "", "lid": {"width_m": 0.2, "mass_kg": 1},
                           "spare": [{"width_m": 0.1}], "handles": {"left": {"position_m": [1, 0, 0]}, "right": {}},
                           "by_colour": {"red": {"width_m": 0.3}}, "heat": "gas", "pressure_bar": 2})",
                       diagnostics);
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  EXPECT_EQ(pot.count, 3);
  EXPECT_EQ(pot.time, 10 * kMillisecond);
  EXPECT_TRUE(pot.hot);
  EXPECT_EQ(pot.label, "") << "an empty text is given";
  EXPECT_EQ(pot.lid, (Lid{0.2, 1.0}));
  EXPECT_THAT(pot.spare, ElementsAre(Lid{0.1, std::nullopt}));
  ASSERT_EQ(pot.handles.size(), 2u);
  EXPECT_EQ(pot.handles[0].name, "left");
  EXPECT_EQ(pot.handles[0].X.translation().x(), 1.0);
  EXPECT_EQ(pot.by_colour.at("red"), (Lid{0.3, std::nullopt}));
  EXPECT_EQ(pot.heat, Pot::Heat::kGas);
  EXPECT_EQ(pot.pressure, 2.0);
}

TEST(FormOf, LeavesAMemberAsItIsWhereTheFileSaysNothing) {
  Diagnostics diagnostics;
  const Pot pot = read("{}", diagnostics);
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  EXPECT_EQ(pot.count, 2);
  EXPECT_EQ(pot.time, 5 * kMillisecond);
  EXPECT_EQ(pot.label, "pot");
  EXPECT_FALSE(pot.lid.has_value());
  EXPECT_EQ(pot.heat, Pot::Heat::kNone);
}

TEST(FormOf, FindsAllThatIsWrongAtOnce) {
  EXPECT_THAT(diagnostics_of(R"({"count": 0, "time_ms": 7, "hot": true, "lid": {"widht_m": 1}, "spare": [],
                                 "handles": {"leftmost": {}}, "by_colour": [], "heat": "steam"})"),
              ElementsAre("out-of-range /pot/count", "out-of-range /pot/time_ms", "missing /pot/lid",
                          "unknown-key /pot/lid/widht_m", "missing /pot/spare", "invalid-name /pot/handles/leftmost",
                          "wrong-type /pot/by_colour", "unknown-name /pot/heat"));
  EXPECT_THAT(diagnostics_of(R"({"hot": true})"), ElementsAre("missing /pot/hot"));
  EXPECT_THAT(diagnostics_of(R"({"heat": "none", "pressure_bar": 2})"), ElementsAre("unknown-key /pot/pressure_bar"))
      << "a key of another kind";
  EXPECT_THAT(diagnostics_of(R"({"heat": "gas"})"), ElementsAre("missing /pot"));
  EXPECT_THAT(diagnostics_of(R"({"handles": {"left": {"rpy_deg": [0, 0, 0], "quaternion": [1, 0, 0, 0]}}})"),
              testing::Contains("conflict /pot/handles/left"));
}

TEST(FormOf, IsPrintedWithTheDefaultsOfItsMembers) {
  Json definitions = Json::object();
  const Json schema = SchemaWriter(definitions).schema_of(pot_form().form());
  const auto at = [&](const std::string& key) { return schema["properties"][key]; };
  EXPECT_EQ(at("count")["default"], 2);
  EXPECT_EQ(at("time_ms")["default"], 5);
  EXPECT_EQ(at("time_ms")["enum"], Json::array({5, 10}));
  EXPECT_EQ(at("hot")["default"], false);
  EXPECT_EQ(at("lid"), Json::parse(R"({"allOf": [{"$ref": "#/definitions/lid"}], "description": "Its lid."})"));
  EXPECT_EQ(at("handles")["propertyNames"]["pattern"], "^.{1,5}$");
  EXPECT_EQ(at("by_colour")["additionalProperties"], Json::parse(R"({"$ref": "#/definitions/lid"})"));
  EXPECT_EQ(at("heat"), Json::parse(R"({"enum": ["none", "gas"], "default": "none", "description": "By what."})"));
  EXPECT_EQ(schema["dependencies"], Json::parse(R"({"hot": ["lid"]})"));
  EXPECT_EQ(schema["allOf"][1]["if"]["properties"]["heat"]["const"], "gas");
  EXPECT_EQ(schema["allOf"][1]["then"]["required"], Json::array({"pressure_bar"}));
  EXPECT_EQ(schema["allOf"][1]["then"]["properties"]["count"], true);
  EXPECT_EQ(definitions["lid"]["required"], Json::array({"width_m"}));
}

}  // namespace
}  // namespace takt::form_of_test
