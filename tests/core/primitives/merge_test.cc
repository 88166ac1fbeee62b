// Merge (row O4): one value, whoever gives it; and fragments that take turns at one arm.
#include <gtest/gtest.h>

#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using net::Boolean;
using net::Real;

HarnessOptions only(std::initializer_list<int> linked) {
  HarnessOptions options;
  for (int i = 1; i <= 16; ++i) {
    if (std::ranges::find(linked, i) == linked.end()) options.unlinked.insert(fmt::format("input_{}", i));
  }
  return options;
}

TEST(Merge, RowO4HandsOnTheInputThatIsNotNull) {
  PrimitiveHarness merge("MergeReal", {{"input_2", nullptr}}, only({1, 5, 16}));
  EXPECT_TRUE(merge.step().is_null("value"));
  EXPECT_EQ(merge.set("input_5", 2.0).step().get<Real>("value"), 2.0);
  EXPECT_EQ(merge.set_null("input_5").set("input_16", 3.0).step().get<Real>("value"), 3.0);
  EXPECT_FALSE(merge.signals().fail);
}

TEST(Merge, RowO4TwoAtATimeFailTheNetAndAreNamed) {
  PrimitiveHarness merge("MergeReal", {{"input_2", nullptr}}, only({1, 5}));
  merge.set("input_1", 1.0).set("input_5", 1.0).step();
  EXPECT_TRUE(merge.is_null("value"));
  EXPECT_EQ(merge.signals().cause.code, net::Cause::Code::kConflict);
  EXPECT_EQ(merge.signals().cause.text.view(), "input_1 and input_5 at once: x");
}

TEST(Merge, TwoInputsMustBeFed) {
  PrimitiveHarness merge("MergeReal", nlohmann::ordered_json::object(), only({1}));
  EXPECT_FALSE(merge.ready());
  EXPECT_NE(merge.findings().to_string().find("'x.input_2' (Real) is not linked"), std::string::npos);
}

TEST(Merge, EveryPayloadKeepsTheContract) {
  for (const net::PrimitiveInfo* info : net::Registry::global().all()) {
    if (info->merge && info->family != "test") {
      check_primitive_contract(info->type, {{"input_2", nullptr}}, only({1}));
    }
  }
}

}  // namespace
}  // namespace takt::test
