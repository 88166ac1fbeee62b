// Deep and wide nets: nothing here may depend on the depth of a stack.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include "tests/core/net/net_support.h"
#include "tests/support/reports.h"

namespace takt::net {
namespace {

using takt::test::Notes;
using takt::test::Reports;

constexpr int kMany = 100'000;

/// Runs `work` on a thread with a stack of 256 KiB: recursion over 100 000 nodes would not survive it.
template <class Work>
void with_small_stack(Work work) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 256 * 1024);
  pthread_t thread;
  ASSERT_EQ(pthread_create(
                &thread, &attributes,
                [](void* argument) -> void* {
                  (*static_cast<Work*>(argument))();
                  return nullptr;
                },
                &work),
            0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
}

std::string id(int i) { return fmt::format("p{:06}", i); }

TEST(Scale, AChain) {
  NetDescription d;
  d.add("end", "TestEnd").add(id(0), "TestAdd", {{"a", 1}, {"b", 0}});
  for (int i = 1; i < kMany; ++i) d.add(id(i), "TestAdd", {{"b", 1}}).link(id(i - 1) + ".out", id(i) + ".a");
  with_small_stack([&] {
    const auto net = make_net(d);
    ASSERT_NE(net, nullptr);
    net->evaluate({});
    EXPECT_EQ(real(*net, id(kMany - 1) + ".out"), static_cast<double>(kMany));
  });
}

TEST(Scale, AStar) {
  NetDescription d;
  d.add("end", "TestEnd").add("hub", "TestCounter").add("r", "TestToReal").link("hub.out", "r.in");
  for (int i = 0; i < kMany; ++i) d.add(id(i), "TestSum").link("r.out", id(i) + ".in");
  with_small_stack([&] {
    const auto net = make_net(d);
    ASSERT_NE(net, nullptr);
    run(*net, 3);
    EXPECT_EQ(real(*net, id(kMany - 1) + ".out"), 3.0);
  });
}

TEST(Scale, AComb) {
  // A spine with a tooth at every node, each tooth a source, a stop at the end: null paths and certificate included.
  NetDescription d;
  d.add(id(0), "TestDivide", {{"a", 1}, {"b", 1}});
  for (int i = 2; i < kMany; i += 2) {
    d.add(id(i), "TestAdd").add(id(i + 1), "TestConstant", {{"value", 1}});
    d.link(id(i - 2) + ".out", id(i) + ".a").link(id(i + 1) + ".out", id(i) + ".b");
  }
  d.add("g", "TestGreater", {{"b", 1e9}})
      .add("end", "TestEnd")
      .link(id(kMany - 2) + ".out", "g.a")
      .link("g.out", "end.in");
  with_small_stack([&] {
    const auto net = make_net(d);
    ASSERT_NE(net, nullptr);
    EXPECT_THAT(net->report().notes, Notes("/primitives/100000", {"end.in"}));
    net->evaluate({});
    EXPECT_EQ(real(*net, id(kMany - 2) + ".out"), static_cast<double>(kMany / 2));
  });
}

TEST(Scale, ARingIsRejectedWithAShortText) {
  NetDescription d;
  d.add("end", "TestEnd");
  for (int i = 0; i < kMany; ++i)
    d.add(id(i), "TestAdd", {{"b", 1}}).link(id((i + kMany - 1) % kMany) + ".out", id(i) + ".a");
  with_small_stack([&] {
    TestDevices devices;
    const auto net = CompiledNet::compile(d, devices);
    ASSERT_FALSE(net.has_value());
    ASSERT_EQ(net.error().list().size(), 1u);
    EXPECT_THAT(net.error(), Reports(Code::kCycleWithoutDelay, "/links/1"));
    EXPECT_LT(net.error().to_string().size(), 2000u);
  });
}

TEST(Scale, FragmentsNestedAHundredThousandDeepAreRejected) {
  with_small_stack([] {
    NetDescription d;
    d.add("end", "TestEnd");
    for (int i = 0; i < kMany; ++i) {
      FragmentDescription f;
      f.id = "f";
      f.net = std::move(d);
      d = NetDescription();
      d.fragments.push_back(std::move(f));
    }
    TestDevices devices;
    const auto net = CompiledNet::compile(d, devices);
    ASSERT_FALSE(net.has_value());
    EXPECT_THAT(net.error(),
                Reports(Code::kTooLarge,
                        "/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/"
                        "net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/"
                        "0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/"
                        "fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/"
                        "net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/"
                        "0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0",
                        {"32"}));
  });
}

TEST(Scale, AThousandBrokenDemandsOverALongChain) {
  NetDescription d;
  d.add("end", "TestEnd").add(id(0), "TestSum", {{"in", 1}});
  for (int i = 1; i < kMany; ++i) d.add(id(i), "TestAdd", {{"b", 1}});
  for (int i = 1; i < kMany; ++i) d.link_delayed(id(i - 1) + ".out", id(i) + ".a", 0.0);
  for (int i = 0; i < 1000; ++i) d.demand(id(0) + ".out", id(kMany - 1 - i) + ".a", 5);
  with_small_stack([&] {
    TestDevices devices;
    const auto net = CompiledNet::compile(d, devices);
    ASSERT_FALSE(net.has_value());
    const Diagnostics text = net.error();
    EXPECT_THAT(text,
                Reports(Code::kReactionBound, "/demands/0/maximum_cycles", {"p000000.out", "p099999.a", "99999"}));
    EXPECT_THAT(text, Reports(Code::kTooLarge, "/demands/49"));
  });
}

/// Conditions whose diagram grows with every step: no proof, but an answer in bounded time.
TEST(Scale, ATangleOfConditionsIsGivenUp) {
  NetDescription d;
  d.add("end", "TestEnd").add("m", "TestMerge");
  std::vector<std::string> any;
  for (int i = 0; i < 100; ++i) {
    d.add(fmt::format("x{:02}", i), "TestTernary");
    any.push_back(fmt::format("x{:02}.out", i));
  }
  std::string sum = any[0];
  for (int i = 0; i < 50; ++i) {
    const std::string pair = fmt::format("p{:02}", i), next = fmt::format("s{:02}", i);
    d.add(pair, "TestAnd").link(any[static_cast<std::size_t>(i)], pair + ".a");
    d.link(any[static_cast<std::size_t>(i) + 50], pair + ".b");
    d.add(next, "TestOr").link(sum, next + ".a").link(pair + ".out", next + ".b");
    sum = next + ".out";
  }
  // Looked at before the sum, this puts one condition of each pair in front of all others.
  std::string half = any[0];
  for (int i = 1; i < 50; ++i) {
    const std::string next = fmt::format("h{:02}", i);
    d.add(next, "TestOr").link(half, next + ".a").link(any[static_cast<std::size_t>(i)], next + ".b");
    half = next + ".out";
  }
  d.add("both", "TestAnd").link(sum, "both.a").link(half, "both.b");
  d.add("not", "TestNot").link(sum, "not.in");
  const std::string actives[] = {"both.out", "not.out"};
  for (int i = 0; i < 2; ++i) {
    FragmentDescription f;
    f.id = fmt::format("f{}", i);
    f.net.add("c", "TestConstant", {{"value", 1}});
    f.outputs.emplace_back("out", "c.out");
    d.link(actives[i], f.id + ".active").link(f.id + ".out", fmt::format("m.input_{}", i + 1));
    d.fragments.push_back(std::move(f));
  }
  with_small_stack([&] {
    const auto net = make_net(d);
    ASSERT_NE(net, nullptr);
    EXPECT_THAT(net->report().notes, Notes("/primitives/1"));
  });
}

TEST(Scale, ManyFragmentsThatTakeTurns) {
  // Pairs of fragments, each pair at a Merge of its own: many small proofs.
  constexpr int kFragments = kMany / 4;
  NetDescription d;
  d.add("end", "TestEnd").add("x", "TestTernary").add("n", "TestNot").link("x.out", "n.in");
  for (int i = 0; i < kFragments; ++i) {
    const std::string a = fmt::format("a{:06}", i), b = fmt::format("b{:06}", i);
    for (const std::string& name : {a, b}) {
      FragmentDescription f;
      f.id = name;
      f.net.add("c", "TestConstant", {{"value", i}});
      f.outputs.emplace_back("out", "c.out");
      d.fragments.push_back(std::move(f));
    }
    d.add(id(i), "TestMerge").link("x.out", a + ".active").link("n.out", b + ".active");
    d.link(a + ".out", id(i) + ".input_1").link(b + ".out", id(i) + ".input_2");
  }
  with_small_stack([&] {
    const auto net = make_net(d);
    ASSERT_NE(net, nullptr);
    ASSERT_EQ(net->report().exclusions.size(), static_cast<std::size_t>(kFragments));
    for (const auto& exclusion : net->report().exclusions) ASSERT_TRUE(exclusion.proven) << exclusion.at;
    net->evaluate({});
    EXPECT_EQ(real(*net, id(kFragments - 1) + ".out"), static_cast<double>(kFragments - 1));
  });
}

TEST(Scale, ProductsOfProductsAreBounded) {
  // u * u again and again: the exponent doubles with every step.
  NetDescription d;
  d.add("end", "TestEnd").add(id(0), "TestMetres");
  for (int i = 1; i < 200; ++i)
    d.add(id(i), "TestMultiply").link(id(i - 1) + ".out", id(i) + ".a").link(id(i - 1) + ".out", id(i) + ".b");
  TestDevices devices;
  const auto net = CompiledNet::compile(d, devices);
  ASSERT_FALSE(net.has_value());
  EXPECT_THAT(net.error(), Reports(Code::kTooLarge, "/links/60"));
}

TEST(Scale, AHundredThousandMistakesAreCounted) {
  NetDescription d;
  for (int i = 0; i < kMany; ++i) d.add(id(i), "TestAdf", {{"q", 1}}).link("nobody.out", id(i) + ".a");
  TestDevices devices;
  const auto net = CompiledNet::compile(d, devices);
  ASSERT_FALSE(net.has_value());
  EXPECT_EQ(net.error().list().size(), 1001u);
  EXPECT_THAT(net.error().list().back(), Reports(Code::kTooLarge, ""));
}

TEST(Scale, LongNamesDoNotFloodTheMessages) {
  const std::string huge(3'000'000, 'n');
  NetDescription d;
  d.add(huge, huge, {{huge, 1}})
      .add("end", "TestEnd")
      .add("a", "TestAdd", {{huge, 1}})
      .link(huge, huge + ".x")
      .link(huge + ".x", "a.a");
  TestDevices devices;
  const auto net = CompiledNet::compile(d, devices);
  ASSERT_FALSE(net.has_value());
  EXPECT_LT(net.error().to_string().size(), 10'000u);
}

}  // namespace
}  // namespace takt::net
