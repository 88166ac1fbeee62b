// Ports 30001 to 30003 of the emulated controller: the layout of what they send, and scripts that come in pieces.
#include "hw/emulators/rtde/script_service.h"

#include <map>

#include "hw/emulators/rtde/client_stream.h"
#include "tests/hw/rtde/controller_bench.h"

namespace takt::hw::rtde {
namespace {

struct StreamPackage {
  int type = 0;
  std::string body;
};

/// The whole packages of a stream; what is left must be nothing.
std::vector<StreamPackage> packages_of(std::string_view stream) {
  std::vector<StreamPackage> packages;
  ByteReader reader(stream);
  while (reader.left() > 0) {
    const auto size = reader.take<std::uint32_t>();
    const auto type = reader.take<std::uint8_t>();
    packages.push_back({type, std::string(reader.take_text(size - 5))});
    EXPECT_TRUE(reader.ok());
    if (!reader.ok()) break;
  }
  return packages;
}
std::string drain(Session& session) { return std::exchange(session.out(), {}); }

class ScriptPorts : public testing::Test {
 protected:
  std::unique_ptr<Session> open(ScriptService& service) {
    auto session = service.open();
    bench.sessions.push_back(session.get());
    return session;
  }
  test::ControllerBench bench;
  ScriptService primary{bench.controller, ScriptService::Stream::kPrimary, true};
  ScriptService secondary{bench.controller, ScriptService::Stream::kSecondary, true};
  ScriptService realtime{bench.controller, ScriptService::Stream::kRealtime, true};
};

TEST_F(ScriptPorts, TheVersionComesFirst) {
  for (ScriptService* service : {&primary, &secondary}) {
    const auto session = open(*service);
    const auto packages = packages_of(drain(*session));
    ASSERT_EQ(packages.size(), 1u);
    EXPECT_EQ(packages[0].type, 20);
    ByteReader reader(packages[0].body);
    (void)reader.take<std::uint64_t>();
    (void)reader.take<std::uint8_t>();
    EXPECT_EQ(reader.take<std::uint8_t>(), 3);
    EXPECT_EQ(reader.take_text(reader.take<std::uint8_t>()), "URControl");
    EXPECT_EQ(reader.take<std::uint8_t>(), 3);
    EXPECT_EQ(reader.take<std::uint8_t>(), 15);
    EXPECT_EQ(reader.take<std::int32_t>(), 8);
  }
  EXPECT_EQ(drain(*open(realtime)), "");
}

TEST_F(ScriptPorts, TheStateHasItsPartsInTheirSizes) {
  const auto session = open(secondary);
  (void)drain(*session);
  bench.seconds(1.0);
  const auto packages = packages_of(drain(*session));
  EXPECT_NEAR(static_cast<double>(packages.size()), 10.0, 1.0) << "a second";
  std::map<int, std::size_t> sizes;
  for (const StreamPackage& part : packages_of(packages.front().body)) sizes[part.type] = part.body.size() + 5;
  const std::map<int, std::size_t> expected = {{0, 47},  {1, 251}, {2, 37}, {3, 75}, {4, 101},
                                               {5, 225}, {6, 445}, {7, 61}, {8, 8}};
  EXPECT_EQ(sizes, expected);
}

TEST_F(ScriptPorts, TheRealtimePackageHasItsSize) {
  const auto session = open(realtime);
  bench.frame();
  const std::string package = drain(*session);
  ByteReader reader(package);
  EXPECT_EQ(reader.take<std::int32_t>(), 1116);
  EXPECT_EQ(package.size(), 1116u);
  EXPECT_NEAR(reader.take<double>(), to_seconds(bench.controller.time()), 1e-9);
  test::ControllerBench newer(test::e_series());
  newer.frame();
  EXPECT_EQ(make_realtime_state(newer.controller).size(), 1220u);
}

TEST_F(ScriptPorts, AProgramMayComeInAnyPieces) {
  const std::string script =
      "stop program\ndef outer():\n  def inner():\n    return 7\n  end\n  textmsg(inner())\nend\n\n";
  for (std::size_t cut = 1; cut < script.size(); cut += 3) {
    const auto session = secondary.open();
    session->receive(script.substr(0, cut));
    bench.frame();
    session->receive(script.substr(cut));
    bench.frames(2);
    EXPECT_EQ(bench.last(ControllerEvent::Kind::kText), "7") << "cut at " << cut;
    bench.controller.events() = {};
  }
}

TEST_F(ScriptPorts, WhatNeverEndsIsDropped) {
  ScriptIntake intake;
  intake.feed("def endless():\n");
  for (int i = 0; i < 200; ++i) intake.feed(std::string(10'000, 'x') + "\n");
  EXPECT_EQ(intake.dropped(), 1);
  EXPECT_FALSE(intake.next() && intake.next()->is_program);
}

TEST(ScriptIntake, ASecondaryProgramIsWholeAsWell) {
  ScriptIntake intake;
  intake.feed("sec later():\n  set_digital_out(1, True)\n");
  EXPECT_FALSE(intake.next()) << "its end is missing";
  intake.feed("end\nsecond()\n");
  const auto program = intake.next();
  ASSERT_TRUE(program);
  EXPECT_TRUE(program->is_program);
  EXPECT_EQ(program->text, "sec later():\n  set_digital_out(1, True)\nend\n");
  const auto line = intake.next();
  ASSERT_TRUE(line);
  EXPECT_FALSE(line->is_program) << "its name only begins like that of one";
}

TEST(ScriptIntake, AProgramEndsWithTheEndThatBelongsToItsBegin) {
  const auto pieces = [](std::string_view text) {
    ScriptIntake intake;
    intake.feed(text);
    std::vector<std::string> found;
    while (const auto piece = intake.next()) found.push_back((piece->is_program ? "program " : "line ") + piece->text);
    return found;
  };
  const std::string flat = "def a():\nif True:\nx = 1\nelif False:\nx = 2\nend\nwhile False:\nend\nend\n";
  EXPECT_EQ(pieces(flat + "b()\n"), (std::vector<std::string>{"program " + flat, "line b()\n"}))
      << "whatever its indentation";
  const std::string indented = "def a():\n  thread t():\n    x = 1\n  end\n  end\n";
  EXPECT_EQ(pieces(indented), std::vector<std::string>{"program " + indented});
  const std::string words = "def a():\n  # end if\n  textmsg(\"end\", 'while')\n  $ 2 \"if end\"\nend # of a\n";
  EXPECT_EQ(pieces(words), std::vector<std::string>{"program " + words}) << "words that are none of the language";
  const std::string short_one = "def a(): return end\n";
  EXPECT_EQ(pieces(short_one + short_one), (std::vector<std::string>{"program " + short_one, "program " + short_one}));
  const std::string wrong = "def a():\n  if 1 ! 2:\n    b()\n  end\n  c()\nend\n";
  EXPECT_EQ(pieces(wrong), std::vector<std::string>{"program " + wrong}) << "one piece, which will be refused";
}

TEST(ScriptIntake, AProgramMayComeInPieces) {
  const std::string text = "def a():\n  if True:\n    b()\n  end\nend\n";
  ScriptIntake intake;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    intake.feed(text.substr(i, 1));
    ASSERT_FALSE(intake.next()) << i;
  }
  intake.feed("\n");
  const auto piece = intake.next();
  ASSERT_TRUE(piece);
  EXPECT_EQ(piece->text, text);
}

TEST_F(ScriptPorts, TheRobotIsLedByHandUntilItIsToRun) {
  run_piece(bench.controller, {"set robotmode freedrive\n", false});
  bench.plant.tau_external << 10, 0, 0, 0, 0, 0;
  const double before = bench.plant.q[0];
  bench.seconds(0.5);
  EXPECT_TRUE(bench.controller.settings().freedrive);
  EXPECT_GT(std::abs(bench.plant.q[0] - before), 0.01) << "it yields";
  run_piece(bench.controller, {"set robotmode run\n", false});
  bench.plant.tau_external.setZero();
  bench.seconds(0.5);
  EXPECT_FALSE(bench.controller.settings().freedrive);
  run_piece(bench.controller, {"set robotmode freedrive\n", false});
  ASSERT_TRUE(bench.controller.programs().start("def go():\n  sleep(1)\nend\n"));
  bench.frames(2);
  EXPECT_FALSE(bench.controller.settings().freedrive) << "a program ends it";
  run_piece(bench.controller, {"set robotmode freedrive\n", false});
  EXPECT_FALSE(bench.controller.settings().freedrive) << "and cannot be disturbed by it";
}

TEST_F(ScriptPorts, EventsGoToThePrimaryClients) {
  const auto session = open(primary);
  (void)drain(*session);
  session->receive("def go():\n  unknown_name()\nend\n");
  session->receive("def ok():\n  textmsg(\"hi\")\nend\n");
  bench.frames(3);
  std::vector<int> kinds;
  for (const StreamPackage& package : packages_of(drain(*session)))
    if (package.type == 20) kinds.push_back(package.body[9]);
  EXPECT_EQ(kinds, (std::vector<int>{10, 7, 0, 7})) << "refused; started, text, stopped";
}

/// Clients compare the state with the message.
TEST_F(ScriptPorts, ASafetyChangeIsPrecededByTheState) {
  const auto session = open(primary);
  bench.frames(2);
  (void)drain(*session);
  bench.controller.protective_stop("x");
  bench.frame();
  const auto packages = packages_of(drain(*session));
  ASSERT_GE(packages.size(), 3u);
  EXPECT_EQ(packages[0].body[9], 6) << "error code";
  EXPECT_EQ(packages[1].type, 16);
  EXPECT_EQ(packages[2].body[9], 5) << "safety mode";
}

TEST_F(ScriptPorts, ReadOnlyPortsTakeNothing) {
  ScriptService watching(bench.controller, ScriptService::Stream::kPrimary, false);
  const auto session = open(watching);
  session->receive("power off\n");
  bench.frame();
  EXPECT_EQ(bench.field("robot_mode"), 7.0);
}

TEST_F(ScriptPorts, AnUnlockOnThePrimaryPortTakesEffectASecondAfterTheStop) {
  bench.controller.protective_stop("x");
  bench.frames(2);
  run_piece(bench.controller, {"set unlock protective stop\n", false});
  bench.seconds(0.5);
  EXPECT_EQ(bench.field("safety_mode"), 3.0);
  bench.seconds(1.0);
  EXPECT_EQ(bench.field("safety_mode"), 1.0);
}

}  // namespace
}  // namespace takt::hw::rtde
