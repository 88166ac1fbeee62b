#include "core/base/object_reader.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/utf8.h"
#include "tests/support/reports.h"

namespace takt {
namespace {

using takt::test::Reports;

using Json = nlohmann::ordered_json;

TEST(ObjectReader, ReadsWhatIsThereAndFallsBackWhereAllowed) {
  Diagnostics diagnostics;
  const Json json =
      Json::parse(R"({"mass_kg": 2, "name": "x", "fixed": true, "position_m": [1, 2, 3], "rpy_deg": [0, 0, 90]})");
  ObjectReader reader(json, "/objects/x", diagnostics);
  EXPECT_EQ(reader.number("mass_kg", {}, kPositive), 2.0);
  EXPECT_EQ(reader.text("name"), "x");
  EXPECT_TRUE(reader.boolean("fixed"));
  EXPECT_EQ(reader.integer("count", 7), 7);
  const Eigen::Isometry3d X = reader.pose();
  EXPECT_TRUE((X * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3)));
  reader.finish();
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
}

TEST(ObjectReader, ATextThatMustBeThereIsNotEmpty) {
  Diagnostics diagnostics;
  const Json json = Json::parse(R"({"urdf": "", "title": "", "comment": ""})");
  ObjectReader reader(json, "/device", diagnostics);
  EXPECT_EQ(reader.text("urdf"), "");
  EXPECT_EQ(reader.text("title", "none"), "");
  reader.finish();
  ASSERT_EQ(diagnostics.list().size(), 1u) << diagnostics.to_string();
  EXPECT_THAT(diagnostics, Reports(Code::kWrongType, "/device/urdf"));
}

TEST(ObjectReader, ReportsAllErrorsAtOnceWithPlaceValueAndChoice) {
  Diagnostics diagnostics;
  const Json json =
      Json::parse(R"({"mass_kg": -1, "nmae": "x", "mode": "fats", "size_m": [1, "a"], "quaternion": [1, 1, 0, 0]})");
  ObjectReader reader(json, "/o", diagnostics);
  (void)reader.number("mass_kg", {}, kPositive);
  (void)reader.text("name");
  (void)reader.choice("mode", {"fast", "slow"});
  (void)reader.numbers("size_m", 2);
  (void)reader.rotation();
  reader.finish();
  const Diagnostics text = diagnostics;
  EXPECT_EQ(diagnostics.list().size(), 6u) << text.to_string();
  EXPECT_THAT(text, Reports(Code::kOutOfRange, "/o/mass_kg", {"-1", "0"}));
  EXPECT_THAT(text, Reports(Code::kMissing, "/o", {"name"}));
  EXPECT_THAT(text, Reports(Code::kUnknownName, "/o/mode", {"fast"}));
  EXPECT_THAT(text, Reports(Code::kWrongType, "/o/size_m/1"));
  EXPECT_THAT(text, Reports(Code::kOutOfRange, "/o/quaternion", {"1.41421"}));
  EXPECT_THAT(text, Reports(Code::kUnknownKey, "/o/nmae", {"nmae", "name"}));
}

TEST(ObjectReader, UnknownKeysAreCountedBeyondABound) {
  Json json = Json::object();
  auto& members = json.get_ref<Json::object_t&>();
  for (int i = 0; i < 50'000; ++i) members.emplace_back(fmt::format("key {}", i), i);
  Diagnostics diagnostics;
  ObjectReader reader(json, "/devices", diagnostics);
  (void)reader.integer("key 7");
  reader.finish();
  ASSERT_EQ(diagnostics.list().size(), 101u);
  EXPECT_EQ(diagnostics.list().back().pointer, "/devices");
  EXPECT_THAT(diagnostics.list().back(), Reports(Code::kUnknownKey, "/devices", {"49899"}));
}

TEST(ObjectReader, MessagesAreCutBetweenCharacters) {
  Json text = "";
  for (int i = 0; i < 100; ++i) text.get_ref<std::string&>() += "\u00e9";
  EXPECT_TRUE(is_utf8(short_dump(text)));
  EXPECT_LE(short_dump(text).size(), 60u);
}

}  // namespace
}  // namespace takt
