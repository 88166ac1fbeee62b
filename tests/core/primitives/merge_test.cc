// Merge (row O4): one value, whoever gives it; and fragments that take turns at one arm.
#include <gtest/gtest.h>

#include "tests/support/primitive_harness.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

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
  EXPECT_THAT(merge.diagnostics(), Reports(Code::kUnlinkedInput, "/primitives/2", {"x.input_2"}));
}

TEST(Merge, EveryPayloadKeepsTheContract) {
  int types = 0;
  for (const net::PrimitiveInfo* info : net::Registry::global().all()) {
    if (!info->merge) continue;
    ++types;
    check_primitive_contract(info->type, {{"input_2", nullptr}}, only({1}));
  }
  EXPECT_EQ(types, 10);
}

/// What an activation means is known of the logic and the comparisons of the library: pairs that exclude each other.
TEST(Merge, RowO4TheLibrarySaysWhatItsAnswersMean) {
  struct Pair {
    const char *one, *one_input, *other, *other_input;
    nlohmann::ordered_json one_limit, other_limit;
  };
  for (const Pair& pair :
       {Pair{"LessThan", "a", "GreaterThan", "a", {{"b", 1.0}}, {{"b", 1.0}}},
        Pair{"LessThan", "a", "InRange", "input", {{"b", 1.0}}, {{"lower", 1.0}, {"upper", 2.0}}},
        Pair{"IsNullReal", "input", "LessThan", "a", nlohmann::ordered_json::object(), {{"b", 1.0}}}}) {
    net::NetDescription net;
    net.add("end", "Termination", {{"condition", false}}).add("m", "MergeReal");
    net.add("x", "Stopwatch", {{"running", true}});
    net.add("one", pair.one, pair.one_limit).link("x.elapsed", std::string("one.") + pair.one_input);
    net.add("other", pair.other, pair.other_limit).link("x.elapsed", std::string("other.") + pair.other_input);
    for (const char* id : {"one", "other"}) {
      net::FragmentDescription fragment;
      fragment.id = std::string("f-") + id;
      fragment.net.add("c", "ConstantReal", {{"value", 1.0}});
      fragment.outputs.emplace_back("out", "c.value");
      net.link(std::string(id) + ".value", fragment.id + ".active");
      net.link(fragment.id + ".out", std::string("m.input_") + (id == std::string_view("one") ? "1" : "2"));
      net.fragments.push_back(std::move(fragment));
    }
    harness::CellEnvironment nothing(nullptr);
    const auto compiled = net::CompiledNet::compile(net, nothing);
    ASSERT_TRUE(compiled.has_value()) << compiled.error().to_string();
    EXPECT_TRUE((*compiled)->report().exclusions.front().proven) << pair.one << " " << pair.other;
  }
}

}  // namespace
}  // namespace takt::test
