// What the emulated controller connects to by itself: sockets of programs, and the client of External Control.
#include <gmock/gmock.h>

#include "hw/emulators/rtde/dashboard_service.h"
#include "hw/rtde/big_endian.h"
#include "hw/wire/virtual_network.h"
#include "tests/hw/rtde/controller_bench.h"

namespace takt::hw::rtde {
namespace {

using testing::HasSubstr;
using Kind = ControllerEvent::Kind;

constexpr std::uint16_t kPort = 50'002;

/// The controller, and another machine on its network that listens.
class UrConnections : public testing::Test {
 protected:
  void SetUp() override {
    auto open = network.listen({kLoopback, kPort});
    ASSERT_TRUE(open);
    listener = std::move(*open);
  }
  void frames(int count) {
    for (int i = 0; i < count; ++i) {
      time += bench.controller.cycle();
      clock.set(time);
      bench.frame();
      if (!client) client = listener->accept();
    }
  }
  void send(std::string_view bytes) { ASSERT_EQ(client->send(std::as_bytes(std::span(bytes))), bytes.size()); }
  std::string received() {
    std::array<std::byte, 256> bytes;
    return {reinterpret_cast<const char*>(bytes.data()), client->receive(bytes)};
  }
  std::string ask(std::string_view command) { return dashboard.answer(command); }

  VirtualClock clock;
  Nanoseconds time = 0;
  VirtualNetwork network{clock, 1};
  std::unique_ptr<StreamListener> listener;
  std::unique_ptr<StreamLink> client;
  test::ControllerBench bench{{.programs = {{"/programs/mine.urp", "def mine():\n  textmsg(\"mine\")\nend\n"},
                                            {"/programs/broken.urp", "def broken(:\n"}},
                               .external_control = Endpoint{kLoopback, kPort}},
                              &network};
  DashboardService dashboard{bench.controller};
};

// A real controller reads on: data that are there cost no control cycle.
TEST_F(UrConnections, AProgramReadsWhatIsThereInOneFrame) {
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  socket_open(\"127.0.0.1\", 50002, \"s\")\n  i = 0\n  sum = 0\n  while i < 500:\n"
      "    a = socket_read_binary_integer(1, \"s\", 2)\n    sum = sum + a[1]\n    i = i + 1\n  end\n"
      "  line = socket_read_line(\"s\")\n  write_output_integer_register(0, sum)\n  textmsg(line)\n"
      "  b = socket_read_byte_list(2, \"s\", 0.1)\n  write_output_integer_register(1, b[0])\nend\n"));
  frames(3);
  ASSERT_TRUE(client);
  std::string bytes;
  for (std::int32_t i = 1; i <= 500; ++i) append(bytes, i);
  send(bytes + "over\n");
  frames(2);
  EXPECT_EQ(bench.field("output_int_register_0"), 125'250.0);
  EXPECT_EQ(bench.last(Kind::kText), "over");
  EXPECT_TRUE(bench.controller.programs().running()) << "it waits for what is not there";
  frames(15);
  EXPECT_FALSE(bench.controller.programs().running()) << "0.1 s are over";
  EXPECT_EQ(bench.field("output_int_register_1"), 0.0);
}

TEST_F(UrConnections, ExternalControlIsPlayedFromTheDashboard) {
  EXPECT_EQ(ask("load external_control.urp"), "Loading program: external_control.urp");
  EXPECT_EQ(ask("play"), "Starting program");
  frames(3);
  ASSERT_TRUE(client);
  EXPECT_EQ(received(), "request_program\n");
  EXPECT_FALSE(bench.controller.programs().running());
  send("# HEADER_BEGIN\nglobal x = 7\n# HEADER_END\n# NODE_CONTROL_LOOP_BEGINS\nwrite_output_integer_register(0, x)\n");
  frames(3);
  EXPECT_FALSE(bench.controller.programs().running()) << "the program is not complete";
  send("while True:\n  sync()\nend\n# NODE_CONTROL_LOOP_ENDS\n");
  frames(3);
  EXPECT_EQ(bench.field("output_int_register_0"), 7.0) << bench.last(Kind::kRuntimeException);
  EXPECT_EQ(ask("programState"), "PLAYING external_control.urp");
  EXPECT_EQ(ask("stop"), "Stopped");
  frames(2);
  EXPECT_EQ(ask("running"), "Program running: false");
}

TEST_F(UrConnections, ExternalControlThatIsStoppedOrGetsNoProgramDoesNotStart) {
  (void)ask("load external_control.urp");
  EXPECT_EQ(ask("play"), "Starting program");
  frames(3);
  ASSERT_TRUE(client);
  EXPECT_EQ(ask("stop"), "Stopped");
  constexpr std::string_view kLate = "textmsg(\"late\")\n# NODE_CONTROL_LOOP_ENDS\n";
  EXPECT_EQ(client->send(std::as_bytes(std::span(kLate))), 0u) << "the connection is closed";
  frames(5);
  EXPECT_EQ(bench.last(Kind::kText), "");
  client.reset();
  EXPECT_EQ(ask("play"), "Starting program");
  frames(800);
  EXPECT_FALSE(bench.controller.programs().running());
  EXPECT_THAT(bench.last(Kind::kError), HasSubstr("127.0.0.1:50002"));
}

TEST_F(UrConnections, ProgramsOfTheInstallationAreLoadedAndPlayed) {
  EXPECT_EQ(ask("load mine.urp"), "Loading program: mine.urp");
  EXPECT_EQ(ask("load broken.urp"), "Error while loading program: broken.urp");
  EXPECT_EQ(ask("get loaded program"), "Loaded program: /programs/mine.urp");
  EXPECT_EQ(ask("play"), "Starting program");
  frames(2);
  EXPECT_EQ(bench.last(Kind::kText), "mine");
}

}  // namespace
}  // namespace takt::hw::rtde
