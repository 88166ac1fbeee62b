// What LOAD refuses: each mistake once, with its JSON pointer and the words that help.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/json.h"
#include "tests/core/net/net_support.h"

namespace takt::net {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
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

constexpr const char* kNoCancel = "the net has no Cancel, so it can only be aborted";

/// Without the one on Cancel, which the nets of these tests do not have.
std::vector<Diagnostic> notes(const NetDescription& net) {
  std::vector<Diagnostic> found = all_notes(net);
  std::erase_if(found, [](const Diagnostic& note) { return note.message.starts_with(kNoCancel); });
  return found;
}

/// A diagnostic at `pointer` whose message and hint contain the texts.
auto is(const std::string& pointer, const std::string& message, const std::string& hint = "") {
  return AllOf(Field("pointer", &Diagnostic::pointer, pointer),
               Field("message", &Diagnostic::message, HasSubstr(message)),
               Field("hint", &Diagnostic::hint, HasSubstr(hint)));
}

NetDescription ending() { return NetDescription().add("end", "TestEnd"); }

TEST(Verification, AnEndingNetIsAccepted) { EXPECT_THAT(errors(ending()), IsEmpty()); }

TEST(Verification, UnknownTypeWithTheNearestOne) {
  EXPECT_THAT(errors(ending().add("x", "TestAdz")), ElementsAre(is("/primitives/1/type", "TestAdz", "'TestAdd'")));
}

TEST(Verification, IdsAreValidAndUnique) {
  EXPECT_THAT(errors(ending().add("end", "TestMetres").add("a.b", "TestMetres").add("", "TestMetres")),
              ElementsAre(is("/primitives/1/id", "duplicate id 'end'"), is("/primitives/2/id", "invalid id 'a.b'"),
                          is("/primitives/3/id", "invalid id ''")));
}

TEST(Verification, Parameters) {
  auto net = ending();
  net.add("a", "TestDrive", {{"device", "left"}, {"speed", 0.0}, {"in", 1.0}});
  net.add("b", "TestDrive", {{"device", "right"}, {"speed", "x"}, {"in", 1.0}, {"mode", "fat"}});
  net.add("c", "TestDrive", {{"device", "lefd"}, {"in", 1.0}, {"spede", 2}});
  net.add("d", "TestDrive", {{"device", "eye"}, {"in", std::nan("")}, {"speed", HUGE_VAL}});
  EXPECT_THAT(errors(net),
              UnorderedElementsAre(
                  is("/primitives/1/parameters/speed", "0 is out of range", "(0,inf)"),
                  is("/primitives/2/parameters/speed", "\"x\" is not a number"),
                  is("/primitives/2/parameters/mode", "'fat' is not allowed", "'fast'"),
                  is("/primitives/3/parameters/spede", "no parameter 'spede'", "'speed'"),
                  is("/primitives/3/parameters", "'speed' is missing", "m/s, (0,inf): how fast"),
                  is("/primitives/3/parameters/device", "no device 'lefd'", "'left'"),
                  is("/primitives/4/parameters/device", "'eye' is of kind camera, not drive", "left, right"),
                  is("/primitives/4/parameters/in", "not finite"), is("/primitives/4/parameters/speed", "not finite")));
}

TEST(Verification, PrepareSpeaksRelativeToTheParameters) {
  EXPECT_THAT(errors(ending().add("a", "TestDrive", {{"device", "left"}, {"speed", 0.5}, {"in", 0}, {"mode", "fast"}})),
              ElementsAre(is("/primitives/1/parameters/speed", "at least 1")));
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
  EXPECT_THAT(errors(net),
              UnorderedElementsAre(
                  is(at + "boolean", "1 is not a Boolean"), is(at + "integer", "1.5 is not an Integer"),
                  is(at + "real", "\"1\" is not a number"), is(at + "text", "63 bytes"),
                  is(at + "vector", "2 elements", "[x,y,z]"), is(at + "rotation", "norm 0.5", "[w,x,y,z]"),
                  is(at + "frame/position/2", "not a number"),
                  is(at + "frame/quaternoin", "unknown key", "'quaternion'"), is(at + "twist", "is not a Twist"),
                  is(at + "wrench/torque/0", "not a number"), is(at + "joints", "13 elements")));
}

TEST(Verification, DanglingLinkEnds) {
  auto net = ending().add("metres", "TestMetres").add("sum", "TestAdd", {{"a", 0}});
  net.link("meters.out", "sum.b").link("metres.uot", "end.in").link("metres.out", "summ.a").link("metres.out", "sum.c");
  net.link("metres", "sum.").link("end.in", "metres.in");
  EXPECT_THAT(errors(net), UnorderedElementsAre(
                               is("/links/0/from", "no primitive or fragment 'meters'", "'metres'"),
                               is("/links/1/from", "'metres' (TestMetres) has no output 'uot'", "'out'"),
                               is("/links/2/to", "'summ'", "'sum'"), is("/links/3/to", "has no input 'c'", "a, b"),
                               is("/links/4/from", "'metres' names no port"), is("/links/4/to", "'sum.' names no port"),
                               is("/links/5/from", "no output 'in'", "no outputs at all"),
                               is("/links/5/to", "no input 'in'", "no inputs at all")));
}

TEST(Verification, WhatLiesOutsideOfAFragmentComesInThroughAPort) {
  auto net = ending().add("m", "TestMetres");
  FragmentDescription f;
  f.id = "f";
  f.net.add("sum", "TestAdd", {{"b", 0}}).link("m.out", "sum.a");
  net.fragments.push_back(f);
  EXPECT_THAT(errors(net),
              ElementsAre(is("/fragments/0/net/links/0/from", "no primitive or fragment 'm'", "through a port")));
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
              ElementsAre(is("/primitives/1/parameters/value", "null is not a number")));
}

TEST(Verification, RowU1AConstantTakesTheUnitOfItsInput) {
  auto net = ending().add("m", "TestMetres").add("sum", "TestAdd", {{"b", 2.5}}).add("sink", "TestForceSink");
  net.link("m.out", "sum.a").link("sum.out", "sink.in");
  EXPECT_THAT(errors(net), ElementsAre(is("/links/1", "'sum.out' is m, but 'sink.in' takes N")))
      << "2.5 says nothing of a unit, so it hides nothing";
}

TEST(Verification, UnitsFramesAndDemandsAreJudgedTogether) {
  auto net = ending().add("m", "TestMetres").add("sink", "TestForceSink").add("arm", "TestArmPose");
  net.add("fb", "TestPose", {{"in", "flange"}, {"of", "base"}}).link("m.out", "sink.in").link("fb.out", "arm.flange");
  net.link_delayed("fb.out", "arm.flange").demand("m.out", "arm.flange", 3).links.pop_back();
  EXPECT_THAT(errors(net), UnorderedElementsAre(is("/links/0", "unit mismatch"), is("/links/1", "frame mismatch"),
                                                is("/demands/0", "nothing leads from 'm.out' to 'arm.flange'")));
}

TEST(Verification, RowN6EveryInputIsFedOnce) {
  auto net = ending().add("a", "TestMetres").add("b", "TestMetres").add("sum", "TestAdd", {{"a", 1.0}});
  net.add("open", "TestAdd", {{"a", 1.0}});
  net.link("a.out", "sum.a").link("a.out", "sum.b").link("b.out", "sum.b");
  EXPECT_THAT(errors(net), UnorderedElementsAre(
                               is("/primitives/3/parameters/a", "'sum.a' has both a link and a constant", "/links/0"),
                               is("/links/2/to", "'sum.b' is linked twice", "/links/1"),
                               is("/primitives/4", "'open.b' (Real) is not linked", "\"b\"")));
}

TEST(Verification, TypesOfBothEnds) {
  auto net = ending().add("n", "TestCounter").add("m", "TestMonitor").link("n.out", "m.in");
  EXPECT_THAT(errors(net), ElementsAre(is("/links/0", "'n.out' is Integer, but 'm.in' takes Real")));
}

TEST(Verification, InitialValues) {
  auto net = ending().add("m", "TestMetres").add("s", "TestAdd").add("t", "TestAdd", {{"b", 0}});
  net.link_delayed("m.out", "s.a", "x").link("m.out", "s.b").link("m.out", "t.a");
  net.links[2].initial = 1.0;
  EXPECT_THAT(errors(net), UnorderedElementsAre(is("/links/0/initial", "not a number"),
                                                is("/links/2/initial", "only a delayed link")));
}

TEST(Verification, RowO2CycleNamesTheShortestChainAndHowToMendIt) {
  auto net = ending();
  net.add("a", "TestAdd").add("b", "TestAdd").add("c", "TestAdd", {{"b", 0}}).add("d", "TestAdd", {{"b", 0}});
  // The long way round a b c d, and the short one b c.
  net.link("a.out", "b.a").link("b.out", "c.a").link("c.out", "d.a").link("d.out", "a.a").link("c.out", "b.b");
  net.link_delayed("d.out", "a.b");
  EXPECT_THAT(errors(net),
              ElementsAre(is("/links/1", "cycle without a delay: b.out -> c.a, c.out -> b.b", "\"delayed\": true")));
  net.links[4].delayed = true;
  EXPECT_THAT(errors(net), ElementsAre(is("/links/0", "a.out -> b.a, b.out -> c.a, c.out -> d.a, d.out -> a.a")));
  net.links[3].delayed = true;
  EXPECT_THAT(errors(net), IsEmpty());
}

TEST(Verification, EveryTangleIsReportedOnce) {
  auto net = ending();
  for (const char* id : {"a", "b", "c"})
    net.add(id, "TestAdd", {{"b", 0}}).link(std::string(id) + ".out", std::string(id) + ".a");
  EXPECT_THAT(errors(net),
              ElementsAre(is("/links/0", "a.out -> a.a"), is("/links/1", "b.out"), is("/links/2", "c.out")));
}

TEST(Verification, ANetMustBeAbleToEnd) {
  EXPECT_THAT(errors(NetDescription().add("m", "TestMetres")), ElementsAre(is("/primitives", "no Termination")));
}

TEST(Verification, RowO4OneDriverPerDevice) {
  auto net = ending();
  for (const char* id : {"a", "b", "c"}) {
    net.add(id, "TestDrive", {{"device", id[0] == 'c' ? "right" : "left"}, {"speed", 1}, {"in", 0}});
  }
  EXPECT_THAT(errors(net), ElementsAre(is("/primitives/2/parameters/device", "'left' is driven by both 'a' and 'b'")));
}

TEST(Verification, RowU1UnitsAreFollowedThroughVariablesAndProducts) {
  auto net = ending().add("m", "TestMetres").add("n", "TestNewtons").add("sum", "TestAdd");
  net.link("m.out", "sum.a").link("n.out", "sum.b");
  EXPECT_THAT(errors(net), ElementsAre(is("/links/1", "unit mismatch: 'n.out' is N, but 'sum.b' takes m")));

  auto product =
      ending().add("m", "TestMetres").add("n", "TestNewtons").add("x", "TestMultiply").add("d", "TestDivide");
  product.add("sink", "TestForceSink");
  product.link("m.out", "x.a").link("n.out", "x.b").link("x.out", "d.a").link("m.out", "d.b").link("d.out", "sink.in");
  EXPECT_THAT(errors(product), IsEmpty()) << "m*N / m = N";
  product.links[3].from = "n.out";
  EXPECT_THAT(errors(product), ElementsAre(is("/links/4", "'d.out' is m, but 'sink.in' takes N")));
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
  EXPECT_THAT(found[0].message, AllOf(HasSubstr("'sum.out' is Nm"), HasSubstr("'wrong.in' takes N")));
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
  EXPECT_THAT(errors(net), ElementsAre(is("/links/7", "'n.out' is N, but 'check.b' takes m")));
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
  EXPECT_THAT(found[0].message, HasSubstr("unit mismatch"));
  EXPECT_THAT(found[0].pointer, HasSubstr("/links/"));
}

TEST(Verification, FreeUnitsAreNoted) {
  auto net = ending().add("c", "TestConstant", {{"value", 1}}).add("s", "TestAdd", {{"b", 0}}).link("c.out", "s.a");
  EXPECT_THAT(notes(net), ElementsAre(is("/primitives/2", "nothing fixes the unit u of 's'")));
}

TEST(Verification, RowL6ANetWithoutCancelIsNoted) {
  EXPECT_THAT(all_notes(ending()), ElementsAre(is("/primitives", kNoCancel, "leads to the Termination")));
}

TEST(Verification, RowU2FramesMustMeet) {
  auto net = ending();
  net.add("wb", "TestPose", {{"in", "world"}, {"of", "base"}})
      .add("bf", "TestPose", {{"in", "base"}, {"of", "flange"}});
  net.add("wf", "TestCompose").add("arm", "TestArmPose").add("fb", "TestPose", {{"in", "flange"}, {"of", "base"}});
  net.link("wb.out", "wf.ab").link("bf.out", "wf.bc").link("wf.out", "arm.flange");
  EXPECT_THAT(errors(net), IsEmpty());
  net.links[1].from = "fb.out";
  EXPECT_THAT(errors(net),
              ElementsAre(is("/links/1", "frame mismatch: 'fb.out' is flange>base, but 'wf.bc' takes base>?")));
  net.links[1].from = "bf.out";
  net.links[2] = {"bf.out", "arm.flange", false, nullptr};
  EXPECT_THAT(errors(net), ElementsAre(is("/links/2", "'bf.out' is base>flange, but 'arm.flange' takes world>flange")));
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
  EXPECT_THAT(notes(net), ElementsAre(is("/primitives/5",
                                         "null can reach 'drive.in': n.out -> r.out -> t.out -> drive.in", "row N4")));
}

TEST(Verification, RowN3NullAtATerminationIsListed) {
  auto net = ending().add("q", "TestDivide", {{"a", 1}, {"b", 0}}).add("g", "TestGreater", {{"b", 0}});
  net.link("q.out", "g.a").link_delayed("g.out", "end.in");
  EXPECT_THAT(notes(net),
              Contains(is("/primitives/0", "g.out (delayed, without an initial value) -> end.in", "row N3")));
  net.links[1].initial = false;
  EXPECT_THAT(notes(net), Contains(is("/primitives/0", "q.out -> g.out -> end.in", "counts as true")));
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
