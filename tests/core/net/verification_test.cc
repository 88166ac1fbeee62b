// What LOAD refuses: each mistake once, with its code, its JSON pointer, and the names that help.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/json.h"
#include "tests/core/net/net_support.h"
#include "tests/support/reports.h"

namespace takt::net {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;

TestDevices cell() {
  TestDevices devices;
  devices.add("left", "drive").add("right", "drive").add("eye", "camera");
  return devices;
}

std::vector<Diagnostic> errors(const NetDescription& net) {
  TestDevices devices = cell();
  const auto compiled = CompiledNet::compile(net, devices);
  if (compiled) return {};
  return compiled.error().list();
}

std::vector<Diagnostic> all_notes(const NetDescription& net) {
  TestDevices devices = cell();
  const auto compiled = CompiledNet::compile(net, devices);
  if (compiled) return (*compiled)->report().notes.list();
  ADD_FAILURE() << compiled.error().to_string();
  return {};
}

/// Without the one on Cancel, which the nets of these tests do not have.
std::vector<Diagnostic> notes(const NetDescription& net) {
  std::vector<Diagnostic> found = all_notes(net);
  std::erase_if(found, [](const Diagnostic& note) {
    return takt::test::fits(note, {Code::kNote, "/primitives", {"Cancel"}, Severity::kNote});
  });
  return found;
}

NetDescription ending() { return NetDescription().add("end", "TestEnd"); }

TEST(Verification, AnEndingNetIsAccepted) { EXPECT_THAT(errors(ending()), IsEmpty()); }

TEST(Verification, UnknownTypeWithTheNearestOne) {
  EXPECT_THAT(errors(ending().add("x", "TestAdz")),
              ElementsAre(Reports(Code::kUnknownName, "/primitives/1/type", {"TestAdd"})));
}

TEST(Verification, IdsAreValidAndUnique) {
  EXPECT_THAT(errors(ending().add("end", "TestMetres").add("a.b", "TestMetres").add("", "TestMetres")),
              ElementsAre(Reports(Code::kDuplicate, "/primitives/1/id", {"end"}),
                          Reports(Code::kInvalidName, "/primitives/2/id", {"a.b"}),
                          Reports(Code::kInvalidName, "/primitives/3/id")));
}

TEST(Verification, Parameters) {
  auto net = ending();
  net.add("a", "TestDrive", {{"device", "left"}, {"speed", 0.0}, {"in", 1.0}});
  net.add("b", "TestDrive", {{"device", "right"}, {"speed", "x"}, {"in", 1.0}, {"mode", "fat"}});
  net.add("c", "TestDrive", {{"device", "lefd"}, {"in", 1.0}, {"spede", 2}});
  net.add("d", "TestDrive", {{"device", "eye"}, {"in", std::nan("")}, {"speed", HUGE_VAL}});
  EXPECT_THAT(errors(net),
              UnorderedElementsAre(Reports(Code::kOutOfRange, "/primitives/1/parameters/speed", {"0"}),
                                   Reports(Code::kSyntax, "/primitives/2/parameters/speed", {"x"}),
                                   Reports(Code::kUnknownName, "/primitives/2/parameters/mode", {"fat", "fast"}),
                                   Reports(Code::kUnknownName, "/primitives/3/parameters/spede", {"spede", "speed"}),
                                   Reports(Code::kMissing, "/primitives/3/parameters", {"speed", "0"}),
                                   Reports(Code::kUnknownName, "/primitives/3/parameters/device", {"lefd", "left"}),
                                   Reports(Code::kUnknownName, "/primitives/4/parameters/device", {"eye"}),
                                   Reports(Code::kSyntax, "/primitives/4/parameters/in"),
                                   Reports(Code::kSyntax, "/primitives/4/parameters/speed")));
}

TEST(Verification, PrepareSpeaksRelativeToTheParameters) {
  EXPECT_THAT(errors(ending().add("a", "TestDrive", {{"device", "left"}, {"speed", 0.5}, {"in", 0}, {"mode", "fast"}})),
              ElementsAre(Reports(Code::kOutOfRange, "/primitives/1/parameters/speed", {"1"})));
}

TEST(Verification, ConstantsOfEveryType) {
  auto net = ending();
  net.add("x", "TestAllTypes",
          {{"boolean", 1},
           {"integer", 1.5},
           {"real", "1"},
           {"text", std::string(64, 'x')},
           {"vector", {1, 2}},
           {"rotation", {0.5, 0, 0, 0}},
           {"frame", {{"position", {1, 2, "3"}}, {"quaternoin", {1, 0, 0, 0}}}},
           {"twist", {1, 2, 3, 4, 5, 6}},
           {"wrench", {{"force", {1, 2, 3}}, {"torque", {true, 2, 3}}}},
           {"joints", std::vector<double>(13)}});
  const std::string at = "/primitives/1/parameters/";
  EXPECT_THAT(
      errors(net),
      UnorderedElementsAre(
          Reports(Code::kSyntax, at + "boolean", {"1"}), Reports(Code::kSyntax, at + "integer", {"1.5"}),
          Reports(Code::kSyntax, at + "real", {"1"}), Reports(Code::kSyntax, at + "text", {"63"}),
          Reports(Code::kWrongSize, at + "vector", {"2"}), Reports(Code::kOutOfRange, at + "rotation", {"0.5"}),
          Reports(Code::kSyntax, at + "frame/position/2"),
          Reports(Code::kUnknownKey, at + "frame/quaternoin", {"quaternion"}), Reports(Code::kSyntax, at + "twist"),
          Reports(Code::kSyntax, at + "wrench/torque/0"), Reports(Code::kWrongSize, at + "joints", {"13"})));
}

TEST(Verification, DanglingLinkEnds) {
  auto net = ending().add("metres", "TestMetres").add("sum", "TestAdd", {{"a", 0}});
  net.link("meters.out", "sum.b").link("metres.uot", "end.in").link("metres.out", "summ.a").link("metres.out", "sum.c");
  net.link("metres", "sum.").link("end.in", "metres.in");
  EXPECT_THAT(errors(net), UnorderedElementsAre(Reports(Code::kUnknownName, "/links/0/from", {"meters", "metres"}),
                                                Reports(Code::kUnknownName, "/links/1/from", {"metres", "uot", "out"}),
                                                Reports(Code::kUnknownName, "/links/2/to", {"summ", "sum"}),
                                                Reports(Code::kUnknownName, "/links/3/to", {"c"}),
                                                Reports(Code::kUnknownName, "/links/4/from", {"metres"}),
                                                Reports(Code::kUnknownName, "/links/4/to", {"sum."}),
                                                Reports(Code::kUnknownName, "/links/5/from", {"in"}),
                                                Reports(Code::kUnknownName, "/links/5/to", {"in"})));
}

TEST(Verification, WhatLiesOutsideOfAFragmentComesInThroughAPort) {
  auto net = ending().add("m", "TestMetres");
  FragmentDescription f;
  f.id = "f";
  f.net.add("sum", "TestAdd", {{"b", 0}}).link("m.out", "sum.a");
  net.fragments.push_back(f);
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kUnknownName, "/fragments/0/net/links/0/from", {"m"})));
}

TEST(Verification, AConstantNullFeedsAnInputOfAnyType) {
  auto net = ending();
  nlohmann::ordered_json nulls;
  for (const auto& port : Registry::global().find("TestAllTypes")->inputs) nulls[port.name] = nullptr;
  net.add("x", "TestAllTypes", nulls).add("sum", "TestAdd", {{"a", nullptr}, {"b", 1}});
  EXPECT_THAT(errors(net), IsEmpty());
  const auto compiled = make_net(net);
  compiled->evaluate({});
  EXPECT_EQ(real(*compiled, "x.real_out"), std::nullopt);
  EXPECT_EQ(real(*compiled, "sum.out"), std::nullopt);
  // A parameter is no input: null is no value for it.
  EXPECT_THAT(errors(ending().add("c", "TestConstant", {{"value", nullptr}})),
              ElementsAre(Reports(Code::kSyntax, "/primitives/1/parameters/value")));
}

TEST(Verification, RowU1AConstantTakesTheUnitOfItsInput) {
  auto net = ending().add("m", "TestMetres").add("sum", "TestAdd", {{"b", 2.5}}).add("sink", "TestForceSink");
  net.link("m.out", "sum.a").link("sum.out", "sink.in");
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kUnitMismatch, "/links/1", {"sum.out", "sink.in"})))
      << "2.5 says nothing of a unit, so it hides nothing";
}

TEST(Verification, UnitsFramesAndDemandsAreJudgedTogether) {
  auto net = ending().add("m", "TestMetres").add("sink", "TestForceSink").add("arm", "TestArmPose");
  net.add("fb", "TestPose", {{"in", "flange"}, {"of", "base"}}).link("m.out", "sink.in").link("fb.out", "arm.flange");
  net.link_delayed("fb.out", "arm.flange").demand("m.out", "arm.flange", 3).links.pop_back();
  EXPECT_THAT(errors(net),
              UnorderedElementsAre(Reports(Code::kUnitMismatch, "/links/0"), Reports(Code::kFrameMismatch, "/links/1"),
                                   Reports(Code::kReactionBound, "/demands/0", {"m.out", "arm.flange"})));
}

TEST(Verification, RowN6EveryInputIsFedOnce) {
  auto net = ending().add("a", "TestMetres").add("b", "TestMetres").add("sum", "TestAdd", {{"a", 1.0}});
  net.add("open", "TestAdd", {{"a", 1.0}});
  net.link("a.out", "sum.a").link("a.out", "sum.b").link("b.out", "sum.b");
  EXPECT_THAT(errors(net), UnorderedElementsAre(Reports(Code::kConflict, "/primitives/3/parameters/a", {"sum.a", "0"}),
                                                Reports(Code::kDuplicate, "/links/2/to", {"sum.b", "1"}),
                                                Reports(Code::kUnlinkedInput, "/primitives/4", {"open.b", "b"})));
}

TEST(Verification, TypesOfBothEnds) {
  auto net = ending().add("n", "TestCounter").add("m", "TestMonitor").link("n.out", "m.in");
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kTypeMismatch, "/links/0", {"n.out", "m.in"})));
}

TEST(Verification, InitialValues) {
  auto net = ending().add("m", "TestMetres").add("s", "TestAdd").add("t", "TestAdd", {{"b", 0}});
  net.link_delayed("m.out", "s.a", "x").link("m.out", "s.b").link("m.out", "t.a");
  net.links[2].initial = 1.0;
  EXPECT_THAT(errors(net), UnorderedElementsAre(Reports(Code::kSyntax, "/links/0/initial"),
                                                Reports(Code::kConflict, "/links/2/initial")));
}

TEST(Verification, RowO2CycleNamesTheShortestChainAndHowToMendIt) {
  auto net = ending();
  net.add("a", "TestAdd").add("b", "TestAdd").add("c", "TestAdd", {{"b", 0}}).add("d", "TestAdd", {{"b", 0}});
  // The long way round a b c d, and the short one b c.
  net.link("a.out", "b.a").link("b.out", "c.a").link("c.out", "d.a").link("d.out", "a.a").link("c.out", "b.b");
  net.link_delayed("d.out", "a.b");
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kCycleWithoutDelay, "/links/1", {"delayed"})));
  net.links[4].delayed = true;
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kCycleWithoutDelay, "/links/0")));
  net.links[3].delayed = true;
  EXPECT_THAT(errors(net), IsEmpty());
}

TEST(Verification, EveryTangleIsReportedOnce) {
  auto net = ending();
  for (const char* id : {"a", "b", "c"})
    net.add(id, "TestAdd", {{"b", 0}}).link(std::string(id) + ".out", std::string(id) + ".a");
  EXPECT_THAT(errors(net),
              ElementsAre(Reports(Code::kCycleWithoutDelay, "/links/0"), Reports(Code::kCycleWithoutDelay, "/links/1"),
                          Reports(Code::kCycleWithoutDelay, "/links/2")));
}

TEST(Verification, ANetMustBeAbleToEnd) {
  EXPECT_THAT(errors(NetDescription().add("m", "TestMetres")), ElementsAre(Reports(Code::kMissing, "/primitives")));
}

TEST(Verification, RowO4OneDriverPerDevice) {
  auto net = ending();
  for (const char* id : {"a", "b", "c"}) {
    net.add(id, "TestDrive", {{"device", id[0] == 'c' ? "right" : "left"}, {"speed", 1}, {"in", 0}});
  }
  EXPECT_THAT(errors(net),
              ElementsAre(Reports(Code::kResourceConflict, "/primitives/2/parameters/device", {"left", "a", "b"})));
}

TEST(Verification, RowU1UnitsAreFollowedThroughVariablesAndProducts) {
  auto net = ending().add("m", "TestMetres").add("n", "TestNewtons").add("sum", "TestAdd");
  net.link("m.out", "sum.a").link("n.out", "sum.b");
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kUnitMismatch, "/links/1", {"n.out", "sum.b"})));

  auto product =
      ending().add("m", "TestMetres").add("n", "TestNewtons").add("x", "TestMultiply").add("d", "TestDivide");
  product.add("sink", "TestForceSink");
  product.link("m.out", "x.a").link("n.out", "x.b").link("x.out", "d.a").link("m.out", "d.b").link("d.out", "sink.in");
  EXPECT_THAT(errors(product), IsEmpty()) << "m*N / m = N";
  product.links[3].from = "n.out";
  EXPECT_THAT(errors(product), ElementsAre(Reports(Code::kUnitMismatch, "/links/4", {"d.out", "sink.in"})));
}

TEST(Verification, RowU1UnitsFlowBackwardsAndThroughFractions) {
  // q = x / y with q in N and y in m makes x Nm, whatever the order of the links.
  auto net = ending().add("c", "TestConstant", {{"value", 1}}).add("d", "TestDivide").add("m", "TestMetres");
  net.add("sink", "TestForceSink").add("sum", "TestAdd", {{"b", 0}});
  net.link("c.out", "d.a").link("c.out", "sum.a").link("m.out", "d.b").link("d.out", "sink.in");
  EXPECT_THAT(errors(net), IsEmpty());
  net.add("wrong", "TestForceSink").link("sum.out", "wrong.in");
  const auto found = errors(net);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0], Reports(Code::kUnitMismatch, "/links/4", {"sum.out", "wrong.in"}));
}

TEST(Verification, RowU1SquaresNeedElimination) {
  // u * u: the exponent of the product is even; root of m^2 is m, and N does not fit.
  auto net = ending().add("c", "TestConstant", {{"value", 1}}).add("x", "TestMultiply").add("m", "TestMetres");
  net.add("mm", "TestMultiply").add("equal", "TestAdd").add("check", "TestAdd");
  net.link("c.out", "x.a").link("c.out", "x.b").link("m.out", "mm.a").link("m.out", "mm.b");
  net.link("x.out", "equal.a").link("mm.out", "equal.b").link("c.out", "check.a").link("m.out", "check.b");
  EXPECT_THAT(errors(net), IsEmpty()) << "c is in m";
  net.add("n", "TestNewtons");
  net.links.back().from = "n.out";
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kUnitMismatch, "/links/7", {"n.out", "check.b"})));
}

TEST(Verification, RowU1JointContradictionOfOpenProducts) {
  // a*b = p and a*b = q with p in m and q in N: no single link is wrong alone.
  auto net = ending().add("a", "TestConstant", {{"value", 1}}).add("b", "TestConstant", {{"value", 1}});
  net.add("x", "TestMultiply").add("y", "TestMultiply").add("m", "TestMetres").add("n", "TestNewtons");
  net.add("p", "TestAdd").add("q", "TestAdd");
  net.link("a.out", "x.a").link("b.out", "x.b").link("a.out", "y.a").link("b.out", "y.b");
  net.link("x.out", "p.a").link("m.out", "p.b").link("y.out", "q.a").link("n.out", "q.b");
  const auto found = errors(net);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0], Reports(Code::kUnitMismatch, "/links/7"));
}

TEST(Verification, FreeUnitsAreNoted) {
  auto net = ending().add("c", "TestConstant", {{"value", 1}}).add("s", "TestAdd", {{"b", 0}}).link("c.out", "s.a");
  EXPECT_THAT(notes(net), ElementsAre(Notes("/primitives/2", {"s"})));
}

TEST(Verification, RowL6ANetWithoutCancelIsNoted) {
  EXPECT_THAT(all_notes(ending()), ElementsAre(Notes("/primitives", {"Cancel"})));
}

TEST(Verification, RowU2FramesMustMeet) {
  auto net = ending();
  net.add("wb", "TestPose", {{"in", "world"}, {"of", "base"}})
      .add("bf", "TestPose", {{"in", "base"}, {"of", "flange"}});
  net.add("wf", "TestCompose").add("arm", "TestArmPose").add("fb", "TestPose", {{"in", "flange"}, {"of", "base"}});
  net.link("wb.out", "wf.ab").link("bf.out", "wf.bc").link("wf.out", "arm.flange");
  EXPECT_THAT(errors(net), IsEmpty());
  net.links[1].from = "fb.out";
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kFrameMismatch, "/links/1", {"fb.out", "wf.bc"})));
  net.links[1].from = "bf.out";
  net.links[2] = {"bf.out", "arm.flange", false, nullptr};
  EXPECT_THAT(errors(net), ElementsAre(Reports(Code::kFrameMismatch, "/links/2", {"bf.out", "arm.flange"})));
}

TEST(Verification, RowN4NullPathsToActuatorsAndStops) {
  auto net =
      ending().add("n", "TestCounter").add("r", "TestToReal").add("s", "TestSum").add("t", "TestAdd", {{"b", 0}});
  net.add("drive", "TestDrive", {{"device", "left"}, {"speed", 1}})
      .add("safe", "TestDrive", {{"device", "right"}, {"speed", 1}});
  net.link("n.out", "r.in")
      .link("r.out", "t.a")
      .link("t.out", "drive.in")
      .link("r.out", "s.in")
      .link("s.out", "safe.in");
  EXPECT_THAT(notes(net), ElementsAre(Notes("/primitives/5", {"drive.in"})));
}

TEST(Verification, RowN3NullAtATerminationIsListed) {
  auto net = ending().add("q", "TestDivide", {{"a", 1}, {"b", 0}}).add("g", "TestGreater", {{"b", 0}});
  net.link("q.out", "g.a").link_delayed("g.out", "end.in");
  EXPECT_THAT(notes(net), Contains(Notes("/primitives/0")));
  net.links[1].initial = false;
  EXPECT_THAT(notes(net), Contains(Notes("/primitives/0")));
}

TEST(Verification, AllMistakesComeAtOnce) {
  const auto document = parse_json(R"({"primitives": [
      {"id": "a", "type": "TestAdd", "parameters": {"a": 1, "x": 2}}, {"id": "a", "type": "TestAddd"},
      {"id": "l", "type": "TestAdd", "parameters": {"a": 1}}, {"id": "q", "type": "TestDrive"}],
    "links": [{"from": "l.out", "to": "l.b"}, {"from": "k.out", "to": "a.b"}]})");
  const auto net = net_from_json(*document);
  ASSERT_TRUE(net.has_value()) << net.error().to_string();
  std::vector<std::string> pointers;
  for (const Diagnostic& diagnostic : errors(*net)) pointers.push_back(diagnostic.pointer);
  EXPECT_THAT(pointers, UnorderedElementsAre("/primitives/0/parameters/x", "/primitives/1/id", "/primitives/1/type",
                                             "/links/1/from", "/primitives/3", "/links/0", "/primitives",
                                             "/primitives/3/parameters", "/primitives/3/parameters"));
}

}  // namespace
}  // namespace takt::net
