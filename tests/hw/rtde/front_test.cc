// The ports of the emulated controller on sockets: clients that come and go.
#include "hw/emulators/rtde/front.h"

#include <poll.h>

#include "hw/wire/posix_network.h"
#include "tests/hw/rtde/controller_bench.h"

namespace takt::hw::rtde {
namespace {

constexpr std::uint32_t kHost = 0x7f000029;  // 127.0.0.41

/// The controller answers twice before it listens again: the second answer finds the connection broken.
TEST(RtdeFront, AScriptCountsWhoseClientClosesAtOnce) {
  hw::PosixNetwork network;
  test::ControllerBench bench;
  auto front = Front::open(network, kHost, bench.controller);
  ASSERT_TRUE(front) << front.error().to_string();
  auto client = network.connect({kHost, kSecondaryPort});
  ASSERT_TRUE(client);
  const auto a_moment = [] { (void)::poll(nullptr, 0, 5); };
  for (int i = 0; i < 200 && (*front)->clients() == 0; ++i) {
    (*front)->exchange();
    a_moment();
  }
  ASSERT_EQ((*front)->clients(), 1u);
  constexpr std::string_view kScript = "sec lamp():\n  set_digital_out(3, True)\nend\n";
  ASSERT_EQ((*client)->state(), hw::StreamLink::State::kOpen);
  ASSERT_EQ((*client)->send(std::as_bytes(std::span(kScript))), kScript.size());
  client->reset();
  for (int i = 0; i < 50; ++i) {  // with the state of the robot in some of them
    a_moment();
    bench.frame();
    (*front)->end_frame();
  }
  for (int i = 0; i < 20; ++i) {
    (*front)->exchange();
    bench.frame();
    a_moment();
  }
  EXPECT_TRUE(bench.controller.io().digital_output(3));
  EXPECT_EQ((*front)->clients(), 0u);
}

}  // namespace
}  // namespace takt::hw::rtde
