// Names in a scenario file: places share one name space, the film names cameras that exist.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/description.h"

namespace takt::scenario::names_test {
namespace {

using testing::HasSubstr;

constexpr const char* kCell = R"({
  "title": "cell",
  "devices": {"arm": {"model": "lwr4plus"}},
  "objects": {
    "block": {"shape": "box", "size_m": [0.1, 0.1, 0.1], "at": {"in": "world", "position_m": [0.5, 0, 0.1]}}
  },
  "program": {"do": "wait", "seconds": 1}
})";

std::string refusal(const std::string& text, const std::vector<Override>& overrides = {}) {
  const auto description = parse_description(text, overrides);
  return description ? "accepted" : description.error().to_string();
}

TEST(Names, PlacesShareOneNameSpace) {
  EXPECT_THAT(refusal(kCell, {{"/objects/arm", R"({"shape": "sphere", "radius_m": 1, "at": {}})"}}),
              HasSubstr("/objects/arm: error: the name 'arm' is used twice in this cell"));
  EXPECT_EQ(refusal(kCell, {{"/cameras", R"({"block": {"at": {}}})"}}), "accepted") << "cameras are no places";
}

TEST(Names, TheFilmNamesCamerasThatExist) {
  const Override cameras{"/cameras", R"({"front": {"at": {}}, "top": {"at": {}}})"};
  EXPECT_EQ(refusal(kCell, {cameras, {"/film", R"({"camera": "front", "inset": "top"})"}}), "accepted");
  const std::string text =
      refusal(kCell, {cameras, {"/film", R"({"camera": "frnt", "cuts": [{"step": "a", "camera": "up"}]})"}});
  EXPECT_THAT(text, HasSubstr("/film/camera: error: there is no camera 'frnt' (did you mean 'front'?"));
  EXPECT_THAT(text, HasSubstr("/film/cuts/0/camera: error: there is no camera 'up'"));
}

}  // namespace
}  // namespace takt::scenario::names_test
