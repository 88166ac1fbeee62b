// The scenario file beyond its form: overrides, names, cameras, draws.
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/description.h"

namespace takt::scenario {
namespace {

using testing::HasSubstr;

constexpr const char* kCell = R"({
  "title": "cell",
  "devices": {"arm": {"model": "lwr4plus"}},
  "objects": {
    "block": {"shape": "box", "size_m": [0.1, 0.1, 0.1], "at": {"in": "world", "position_m": [0.5, 0, 0.1]},
              "vary": {"radius_m": 0.015, "position_m": [0, 0, 0.002], "rpy_deg": [0, 0, 5]}}
  },
  "program": {"do": "wait", "seconds": 1}
})";

std::string refusal(const std::string& text, const std::vector<Override>& overrides = {}) {
  const auto description = parse_description(text, overrides);
  return description ? "accepted" : description.error().to_string();
}

TEST(Description, OverridesChangeAndAddValuesBeforeTheCheck) {
  const auto changed = parse_description(
      kCell, {{"/devices/arm/model", "ur5"}, {"/plant_mass_scale", "1.1"}, {"/title", "\"quoted\""}}, 42);
  ASSERT_TRUE(changed.has_value());
  EXPECT_EQ(changed->devices[0].model, "ur5");
  EXPECT_EQ(changed->plant_mass_scale, 1.1);
  EXPECT_EQ(changed->title, "quoted");
  EXPECT_EQ(changed->seed, 42u);
  EXPECT_THAT(changed->text, HasSubstr("\"ur5\"")) << "recordings carry the file as it was run";
}

TEST(Description, OverridesAreChecked) {
  EXPECT_THAT(refusal(kCell, {{"/devices/leg/model", "x"}}),
              HasSubstr("/devices/leg/model: error: --set names a place"));
  EXPECT_THAT(refusal(kCell, {{"seed", "1"}}), HasSubstr("--set needs a JSON pointer"));
  EXPECT_THAT(refusal(kCell, {{"/seed", "many"}}), HasSubstr("/seed: error: \"many\" stands here"));
  EXPECT_THAT(refusal(kCell, {{"/sead", "1"}}),
              HasSubstr("/sead: error: key 'sead' is not known here (did you mean 'seed'"));
}

TEST(Description, PlacesShareOneNameSpace) {
  EXPECT_THAT(refusal(kCell, {{"/objects/arm", R"({"shape": "sphere", "radius_m": 1, "at": {}})"}}),
              HasSubstr("/objects/arm: error: the name 'arm' is used twice in this cell"));
  EXPECT_EQ(refusal(kCell, {{"/cameras", R"({"block": {"at": {}}})"}}), "accepted") << "cameras are no places";
}

TEST(Description, TheFilmNamesCamerasThatExist) {
  const Override cameras{"/cameras", R"({"front": {"at": {}}, "top": {"at": {}}})"};
  EXPECT_EQ(refusal(kCell, {cameras, {"/film", R"({"camera": "front", "inset": "top"})"}}), "accepted");
  const std::string text =
      refusal(kCell, {cameras, {"/film", R"({"camera": "frnt", "cuts": [{"step": "a", "camera": "up"}]})"}});
  EXPECT_THAT(text, HasSubstr("/film/camera: error: there is no camera 'frnt' (did you mean 'front'?"));
  EXPECT_THAT(text, HasSubstr("/film/cuts/0/camera: error: there is no camera 'up'"));
}

TEST(Description, AllMistakesComeAtOnce) {
  const std::string text = refusal(R"({"sed": 1, "time_limit_s": 0, "devices": {"arm": {}}, "objects": 3})");
  for (const char* pointer : {"/sed", "/time_limit_s", "/devices/arm", "/objects"}) {
    EXPECT_THAT(text, HasSubstr(std::string(pointer) + ": error"));
  }
  EXPECT_THAT(text, HasSubstr("key 'program' is missing"));
}

TEST(Draw, D5_StaysInsideItsBoundsAndUsesThem) {
  const auto description = parse_description(kCell);
  const ObjectEntry& block = description->objects[0];
  double farthest = 0.0, highest = 0.0, most_turned = 0.0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const Eigen::Isometry3d X = block.at.X.inverse() * drawn_pose(block, seed);
    const double yaw = std::atan2(X(1, 0), X(0, 0)) * 180 / M_PI;
    farthest = std::max(farthest, X.translation().head<2>().norm());
    highest = std::max(highest, std::abs(X.translation().z()));
    most_turned = std::max(most_turned, std::abs(yaw));
    ASSERT_NEAR(X(2, 2), 1.0, 1e-12) << "yaw only";
  }
  EXPECT_LE(farthest, 0.015);
  EXPECT_GT(farthest, 0.0145);
  EXPECT_LE(highest, 0.002 + 1e-12);
  EXPECT_GT(highest, 0.0019);
  EXPECT_LE(most_turned, 5.0 + 1e-9);
  EXPECT_GT(most_turned, 4.9);
}

TEST(Draw, D5_DependsOnSeedAndNameAlone) {
  const auto alone = parse_description(kCell);
  const auto crowded = parse_description(
      kCell, {{"/objects/another", R"({"shape": "sphere", "radius_m": 1, "at": {}, "vary": {"radius_m": 1}})"}});
  const auto find = [](const Description& description, const std::string& name) {
    return *std::ranges::find(description.objects, name, &ObjectEntry::name);
  };
  const ObjectEntry a = find(*alone, "block"), b = find(*crowded, "block");
  EXPECT_EQ(drawn_pose(a, 5).matrix(), drawn_pose(b, 5).matrix());
  EXPECT_NE(drawn_pose(a, 5).matrix(), drawn_pose(a, 6).matrix());
  ObjectEntry renamed = a;
  renamed.name = "brick";
  EXPECT_NE(drawn_pose(a, 5).matrix(), drawn_pose(renamed, 5).matrix());
}

}  // namespace
}  // namespace takt::scenario
