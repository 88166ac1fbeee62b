// Names in a scenario file: places share one name space, the film names cameras that exist.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/file/description.h"
#include "tests/support/reports.h"

namespace takt::cell::names_test {
namespace {

using takt::test::Reports;

constexpr const char* kCell = R"({
  "title": "cell",
  "devices": {"arm": {"model": "lwr4plus"}},
  "objects": {
    "block": {"shape": "box", "size_m": [0.1, 0.1, 0.1], "at": {"in": "world", "position_m": [0.5, 0, 0.1]}}
  },
  "program": {"do": "wait", "seconds": 1}
})";

Diagnostics refusal(const std::string& text, const std::vector<Override>& overrides = {}) {
  const auto description = parse_description(text, overrides);
  return description ? Diagnostics() : description.error();
}

TEST(Names, FramesShareOneNameSpace) {
  EXPECT_THAT(refusal(kCell, {{"/objects/arm", R"({"shape": "sphere", "radius_m": 1, "at": {}})"}}),
              Reports(Code::kDuplicate, "/objects/arm", {"arm"}));
  EXPECT_TRUE(refusal(kCell, {{"/cameras", R"({"block": {"at": {}}})"}}).empty()) << "cameras are no frames";
}

TEST(Names, TheFilmNamesCamerasThatExist) {
  const Override cameras{"/cameras", R"({"front": {"at": {}}, "top": {"at": {}}})"};
  EXPECT_TRUE(refusal(kCell, {cameras, {"/film", R"({"camera": "front", "inset": "top"})"}}).empty());
  EXPECT_THAT(refusal(kCell, {cameras, {"/film", R"({"camera": "frnt", "cuts": [{"step": "a", "camera": "up"}]})"}}),
              testing::AllOf(Reports(Code::kUnknownName, "/film/camera", {"frnt", "front"}),
                             Reports(Code::kUnknownName, "/film/cuts/0/camera", {"up"})));
}

}  // namespace
}  // namespace takt::cell::names_test
