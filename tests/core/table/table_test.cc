// One table: what it reads, what it refuses, what it prints.
#include "core/table/table.h"

#include <memory>
#include <numbers>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/table/kinds.h"
#include "core/table/schema.h"
#include "tests/support/reports.h"

namespace takt::table {
namespace {

using takt::test::Reports;
using ::testing::AllOf;
using ::testing::ElementsAre;
using Json = nlohmann::ordered_json;

struct Wheel {
  std::string name = {};
  double radius = 0.3;
  std::optional<double> turn = {};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};

const Table<Wheel>& wheel_table() {
  static const auto table = [] {
    Table<Wheel> wheel;
    wheel.number("radius_m", "m", &Wheel::radius, kPositive, "Radius.")
        .number("turn_deg", "deg", &Wheel::turn, {.low = -90, .high = 90}, "Turn.")
        .pose(&Wheel::X);
    return wheel;
  }();
  return table;
}

enum class Drive { kNone, kEngine, kHorse };

struct Cart {
  std::string owner = {};
  Drive drive = Drive::kNone;
  double power = 0.0;
  std::int64_t horses = 0;
  std::optional<double> load = {}, trailer = {};
  std::vector<Wheel> wheels = {};
  std::vector<Wheel> spare = {};
  Wheel steering = {};
};

const Table<Cart>& cart_table() {
  static const auto engine = [] {
    Table<Cart> more;
    more.number("power_W", "W", &Cart::power, kPositive, "Power.").required();
    return more;
  }();
  static const auto horse = [] {
    Table<Cart> more;
    more.integer("horses", &Cart::horses, {.low = 1, .high = 8}, "Number of horses.").required();
    return more;
  }();
  static const auto table = [] {
    Table<Cart> cart;
    cart.text("owner", &Cart::owner, "Who owns it.")
        .required()
        .choose<Drive>(
            "drive", &Cart::drive,
            {{"none", Drive::kNone}, {"engine", Drive::kEngine, {}, &engine}, {"horse", Drive::kHorse, {}, &horse}},
            "What moves it.")
        .number("load_kg", "kg", &Cart::load, kNotNegative, "Load.")
        .number("trailer_kg", "kg", &Cart::trailer, kNotNegative, "Load of the trailer.")
        .elements("wheels", "wheel", wheel_table(), &Cart::wheels, "Wheels.", {.min = 1, .max = 8})
        .members("spare", "wheel", wheel_table(), &Cart::spare, "Spare wheels by name.")
        .part("steering", "wheel", wheel_table(), &Cart::steering, "Steering wheel.")
        .refuse("sail", "a cart has no sail", "Remove it")
        .rule({.kind = Rule::Kind::kNotTogether, .groups = {{"load_kg"}, {"trailer_kg"}}, .hint = "Remove one"})
        .rule({.kind = Rule::Kind::kNeeds,
               .groups = {{"trailer_kg"}, {"wheels"}},
               .hint = "Add wheels",
               .at = "trailer_kg",
               .code = Code::kInvalidValue});
    return cart;
  }();
  return table;
}

Cart read(const char* text, Diagnostics& diagnostics) {
  const Json json = Json::parse(text);
  ObjectReader reader(json, "", diagnostics);
  return cart_table().read_object(reader);
}

Diagnostics wrong(const char* text) {
  Diagnostics diagnostics;
  (void)read(text, diagnostics);
  return diagnostics;
}

TEST(Table, ReadsInUnitsOfFilesAndKeepsSi) {
  Diagnostics diagnostics;
  const Cart cart = read(R"({"owner": "me", "drive": "horse", "horses": 2,
      "wheels": [{"radius_m": 0.5, "turn_deg": 45}, {"position_m": [1, 2, 3], "rpy_deg": [0, 0, 180]}],
      "spare": {"old": {"radius_m": 0.4}}, "steering": {"turn_deg": -90}})",
                         diagnostics);
  EXPECT_EQ(diagnostics.to_string(), "");
  EXPECT_EQ(cart.drive, Drive::kHorse);
  EXPECT_EQ(cart.horses, 2);
  ASSERT_EQ(cart.wheels.size(), 2U);
  EXPECT_DOUBLE_EQ(*cart.wheels[0].turn, std::numbers::pi / 4);
  EXPECT_FALSE(cart.wheels[1].turn);
  EXPECT_EQ(cart.wheels[1].radius, 0.3) << "the default of the struct";
  EXPECT_EQ(cart.wheels[1].X.translation(), Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(cart.spare.size(), 1U);
  EXPECT_EQ(cart.spare[0].name, "old");
  EXPECT_DOUBLE_EQ(*cart.steering.turn, -std::numbers::pi / 2);
}

TEST(Table, SaysAllThatIsWrongAtOnce) {
  EXPECT_THAT(wrong(R"({"drive": "engine", "wheels": [], "spare": {"a/b": {"radius_m": 0}}, "colour": 1, "sail": 1})"),
              AllOf(Reports(Code::kMissing, "", {"owner"}), Reports(Code::kMissing, "", {"power_W"}),
                    Reports(Code::kMissing, "/wheels"), Reports(Code::kInvalidName, "/spare/a~1b"),
                    Reports(Code::kOutOfRange, "/spare/a~1b/radius_m"), Reports(Code::kUnknownKey, "/colour"),
                    Reports(Code::kConflict, "/sail")));
}

TEST(Table, RulesAboutSeveralKeysAreChecked) {
  EXPECT_THAT(wrong(R"({"owner": "me", "load_kg": 1, "trailer_kg": 1, "wheels": [{}]})"),
              Reports(Code::kConflict, "", {"load_kg", "trailer_kg"}));
  EXPECT_THAT(wrong(R"({"owner": "me", "trailer_kg": 1})"), Reports(Code::kInvalidValue, "/trailer_kg", {"wheels"}));
  EXPECT_EQ(wrong(R"({"owner": "me", "trailer_kg": 1, "wheels": [{}]})").to_string(), "");
}

TEST(Table, AWordBringsItsKeysAndNoOthers) {
  EXPECT_THAT(wrong(R"({"owner": "me", "drive": "horse", "horses": 1, "power_W": 5})"),
              Reports(Code::kUnknownKey, "/power_W"));
  EXPECT_THAT(wrong(R"({"owner": "me", "horses": 1})"), Reports(Code::kUnknownKey, "/horses"));
  EXPECT_THAT(wrong(R"({"owner": "me", "drive": "sail"})"), Reports(Code::kUnknownName, "/drive", {"sail"}));
}

TEST(Table, AreData) {
  const Field form = cart_table().form("cart", "A cart.");
  std::vector<std::string> keys;
  for (const Field& one : form.fields)
    if (!one.refused) keys.push_back(one.key);
  EXPECT_THAT(keys, ElementsAre("owner", "drive", "load_kg", "trailer_kg", "wheels", "spare", "steering"));
  EXPECT_EQ(form.discriminator, "drive");
  ASSERT_EQ(form.variants.size(), 3U);
  EXPECT_EQ(form.variants[1].fields.front().unit, "W");
  EXPECT_EQ(form.rules.size(), 2U);
}

TEST(Schema, StatesWhatTheTableReads) {
  SchemaPrinter printer;
  printer.define(cart_table().form("cart"));
  const Json& cart = printer.definitions().at("cart");
  EXPECT_EQ(cart.at("required"), Json::parse(R"(["owner"])"));
  EXPECT_EQ(cart.at("additionalProperties"), false);
  const Json& properties = cart.at("properties");
  EXPECT_FALSE(properties.contains("sail"));
  EXPECT_EQ(properties.at("owner").at("minLength"), 1) << "a text that must be there names something";
  EXPECT_EQ(properties.at("drive").at("enum"), Json::parse(R"(["none", "engine", "horse"])"));
  EXPECT_EQ(properties.at("wheels").at("items"), Json::parse(R"({"$ref": "#/definitions/wheel"})"));
  EXPECT_EQ(properties.at("wheels").at("minItems"), 1);
  EXPECT_EQ(properties.at("spare").at("additionalProperties").at("$ref"), "#/definitions/wheel");
  EXPECT_EQ(cart.at("not"), Json::parse(R"({"required": ["load_kg", "trailer_kg"]})"));
  EXPECT_EQ(cart.at("dependencies"), Json::parse(R"({"trailer_kg": ["wheels"]})"));
  const Json& engine = cart.at("allOf").at(1);
  EXPECT_EQ(engine.at("if").at("properties").at("drive").at("const"), "engine");
  EXPECT_EQ(engine.at("then").at("required"), Json::parse(R"(["power_W"])"));
  EXPECT_EQ(engine.at("then").at("properties").at("horses"), false);
  const Json& wheel = printer.definitions().at("wheel").at("properties");
  EXPECT_EQ(wheel.at("radius_m").at("exclusiveMinimum"), 0);
  EXPECT_EQ(wheel.at("turn_deg").at("minimum"), -90) << "in the unit of files";
}

TEST(Schema, OnlyTextsMakeLongLinesOfAPage) {
  SchemaPrinter printer;
  printer.define(cart_table().form("cart"));
  const std::string page = page_of({{"definitions", printer.definitions()}});
  EXPECT_EQ(Json::parse(page).at("definitions"), printer.definitions());
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_of("{[") != std::string::npos) EXPECT_LE(line.size(), 120U) << line;
}

// -- Kinds -----------------------------------------------------------------------------------------------------------

struct Bell {
  std::int64_t strokes = 1;
};

const Table<Bell>& bell_table() {
  static const auto table = [] {
    Table<Bell> bell;
    bell.integer("strokes", &Bell::strokes, kPositive, "Number of strokes.");
    return bell;
  }();
  return table;
}

Kind<std::string> bell_kind() {
  return {.name = "bell", .doc = "Rings.", .keys = object_of<bell_table>, .read = [](ObjectReader& reader) {
            Bell bell;
            bell_table().read_into(bell, {reader});
            return std::string(static_cast<std::size_t>(bell.strokes), '*');
          }};
}

TEST(Kinds, ArePickedByTheirName) {
  Kinds<std::string> kinds("sound");
  kinds.add(bell_kind());
  const Json json = Json::parse(R"({"do": "bell", "strokes": 3})");
  Diagnostics diagnostics;
  ObjectReader reader(json, "", diagnostics);
  const auto* kind = kinds.read("do", reader);
  ASSERT_NE(kind, nullptr);
  EXPECT_EQ(kind->read(reader), "***");
  const Json none = Json::parse(R"({"do": "bel"})");
  ObjectReader misspelt(none, "/sounds/0", diagnostics);
  EXPECT_EQ(kinds.read("do", misspelt), nullptr);
  EXPECT_THAT(diagnostics, Reports(Code::kUnknownName, "/sounds/0/do", {"bel", "bell"}));
}

TEST(Kinds, OfPlugInsAreChecked) {
  Kinds<std::string> kinds("sound");
  Registration* list = nullptr;
  KindRegistration<std::string> first(list, kinds, bell_kind());
  EXPECT_EQ(first.check().to_string(), "");
  first.add();
  EXPECT_THAT(first.check(), Reports(Code::kDuplicate, "", {"bell"}));
  Kind<std::string> nameless = bell_kind();
  nameless.name = "";
  EXPECT_THAT(KindRegistration<std::string>(list, kinds, nameless).check(), Reports(Code::kMissing, ""));
}

}  // namespace
}  // namespace takt::table
