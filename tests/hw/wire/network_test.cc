// The same duties of both networks: sockets of the machine, and the virtual wire.
#include <signal.h>
#include <sys/time.h>

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "hw/wire/posix_network.h"
#include "hw/wire/virtual_network.h"

namespace takt::hw {
namespace {

/// A network on the bench: how time goes on is all in which they differ.
struct NetworkBench {
  virtual ~NetworkBench() = default;
  /// Waits until a link has something, as its user would.
  virtual void pass(Nanoseconds time) = 0;
  Network* network = nullptr;
};

struct PosixBench final : NetworkBench {
  PosixBench() { network = &posix; }
  void pass(Nanoseconds) override {}
  PosixNetwork posix;
};

struct VirtualBench final : NetworkBench {
  VirtualBench() { network = &wire; }
  void pass(Nanoseconds time) override { clock.set(clock.now() + time); }
  VirtualClock clock;
  VirtualNetwork wire{clock, 1, {.wire = {.transport = 100'000}, .stream_piece = 3}};
};

struct BenchMaker {
  const char* name;
  std::unique_ptr<NetworkBench> (*make)();
};

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

class AnyNetwork : public testing::TestWithParam<BenchMaker> {
 protected:
  void SetUp() override { bench = GetParam().make(); }

  std::unique_ptr<DatagramLink> datagrams(const Endpoint& local = {kLoopback, 0}) {
    auto link = bench->network->open_datagrams(local);
    EXPECT_TRUE(link) << link.error().to_string();
    return std::move(*link);
  }
  template <class Link>
  bool wait(Link& link) {
    bench->pass(kMillisecond);
    return link.wait(kSecond);
  }
  /// A connection: the end that connected, the end that accepted.
  std::pair<std::unique_ptr<StreamLink>, std::unique_ptr<StreamLink>> connected() {
    listener = std::move(*bench->network->listen({kLoopback, 0}));
    auto client = std::move(*bench->network->connect(listener->local()));
    EXPECT_TRUE(wait(*listener));
    auto server = listener->accept();
    if (client->state() == StreamLink::State::kConnecting) (void)wait(*client);
    EXPECT_EQ(client->state(), StreamLink::State::kOpen);
    EXPECT_EQ(server->remote(), client->local());
    return {std::move(client), std::move(server)};
  }
  /// Until so many bytes have come, or nothing more does.
  std::string receive(StreamLink& link, std::size_t count) {
    std::string text;
    std::array<std::byte, 100> buffer;
    while (text.size() < count && wait(link)) {
      const std::size_t size = link.receive(std::span(buffer).first(std::min(buffer.size(), count - text.size())));
      if (size == 0 && link.state() != StreamLink::State::kOpen) break;
      text.append(reinterpret_cast<const char*>(buffer.data()), size);
    }
    return text;
  }

  std::unique_ptr<NetworkBench> bench;
  std::unique_ptr<StreamListener> listener;
};

TEST_P(AnyNetwork, DatagramsKeepTheirBoundariesAndSayWhereTheyComeFrom) {
  const auto a = datagrams(), b = datagrams();
  ASSERT_NE(a->local().port, 0);
  std::array<std::byte, 8> buffer{};
  EXPECT_FALSE(b->receive(buffer)) << "nothing came, and nobody waits";
  EXPECT_TRUE(a->send(bytes_of("abc"), b->local()));
  EXPECT_TRUE(a->send({}, b->local())) << "an empty one is one";
  EXPECT_TRUE(a->send(bytes_of("longer than the buffer"), b->local()));
  ASSERT_TRUE(wait(*b));
  const auto first = b->receive(buffer), second = b->receive(buffer), third = b->receive(buffer);
  ASSERT_TRUE(first && second && third);
  EXPECT_EQ(first->size, 3u);
  EXPECT_EQ(first->from, a->local());
  EXPECT_EQ(second->size, 0u);
  EXPECT_EQ(third->size, 22u) << "its own size, although it was cut off";
  EXPECT_EQ(static_cast<char>(buffer[7]), 't');
  EXPECT_FALSE(b->receive(buffer));
  EXPECT_EQ(b->counts().received, 3u);
  EXPECT_EQ(a->counts().sent, 3u);
}

TEST_P(AnyNetwork, NobodyAtTheOtherEndHarmsNobody) {
  const auto a = datagrams();
  const Endpoint gone = datagrams()->local();
  std::array<std::byte, 8> buffer{};
  for (int i = 0; i < 100; ++i) {
    (void)a->send(bytes_of("hello"), gone);
    bench->pass(kMillisecond);
    EXPECT_FALSE(a->receive(buffer)) << "a refused connection is no datagram";
  }
  const auto back = datagrams(gone);
  EXPECT_TRUE(a->send(bytes_of("hello"), gone));
  EXPECT_TRUE(wait(*back)) << "it works again once somebody is there";
}

TEST_P(AnyNetwork, APortThatIsInUseIsRefusedWithItsNumber) {
  const auto a = datagrams();
  const auto again = bench->network->open_datagrams(a->local());
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().to_string().find(std::to_string(a->local().port)), std::string::npos);
  const auto listening = bench->network->listen({kLoopback, 0});
  ASSERT_TRUE(listening);
  EXPECT_FALSE(bench->network->listen((*listening)->local()));
}

TEST_P(AnyNetwork, AStreamCarriesAllBytesInOrderInWhateverPieces) {
  const auto [client, server] = connected();
  std::string text;
  for (int i = 0; i < 200; ++i) text += std::to_string(i) + ",";
  EXPECT_EQ(client->send(bytes_of(text)), text.size());
  EXPECT_EQ(receive(*server, text.size()), text);
  EXPECT_EQ(server->send(bytes_of("and back")), 8u);
  EXPECT_EQ(receive(*client, 8), "and back");
}

TEST_P(AnyNetwork, APeerThatDoesNotReadIsNotWaitedFor) {
  const auto [client, server] = connected();
  const std::string block(100'000, 'x');
  std::size_t accepted = 0;
  // A socket's buffers hold some megabytes at most.
  for (int i = 0; i < 1000; ++i) accepted += client->send(bytes_of(block));
  EXPECT_LT(accepted, 1000 * block.size());
  EXPECT_EQ(client->state(), StreamLink::State::kOpen);
  EXPECT_EQ(receive(*server, accepted).size(), accepted);
}

TEST_P(AnyNetwork, AnEndIsSeenAfterTheLastByteAndRaisesNoSignal) {
  auto [client, server] = connected();
  EXPECT_EQ(client->send(bytes_of("last words")), 10u);
  client->close();
  EXPECT_EQ(client->state(), StreamLink::State::kFailed);
  EXPECT_EQ(client->send(bytes_of("more")), 0u);
  EXPECT_EQ(receive(*server, 100), "last words");
  EXPECT_EQ(server->state(), StreamLink::State::kEnded);
  for (int i = 0; i < 10 && server->state() == StreamLink::State::kEnded; ++i) {
    (void)server->send(bytes_of("too late"));  // SIGPIPE would end this process
    bench->pass(kMillisecond);
  }
  EXPECT_EQ(server->state(), StreamLink::State::kFailed);
  EXPECT_FALSE(server->error().empty());
}

TEST_P(AnyNetwork, WhatCameCountsThoughNothingCanBeSentAnyMore) {
  auto [client, server] = connected();
  EXPECT_EQ(client->send(bytes_of("last words")), 10u);
  client.reset();
  for (int i = 0; i < 5; ++i) {
    (void)server->send(bytes_of("too late"));
    bench->pass(kMillisecond);
  }
  EXPECT_EQ(receive(*server, 100), "last words");
  (void)server->send(bytes_of("too late"));
  EXPECT_NE(server->state(), StreamLink::State::kOpen);
}

TEST_P(AnyNetwork, AConnectionThatNobodyAcceptsFailsWithAReason) {
  Endpoint gone;
  {
    const auto listening = std::move(*bench->network->listen({kLoopback, 0}));
    gone = listening->local();
  }
  const auto link = bench->network->connect(gone);
  if (!link) return;  // a socket may know at once
  (void)wait(**link);
  EXPECT_EQ((*link)->state(), StreamLink::State::kFailed);
  EXPECT_NE((*link)->error().find("refused"), std::string::npos) << (*link)->error();
}

std::string name_of_bench(const testing::TestParamInfo<BenchMaker>& tested) { return tested.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Both, AnyNetwork,
    testing::Values(BenchMaker{"Posix", [] { return std::unique_ptr<NetworkBench>(new PosixBench); }},
                    BenchMaker{"Virtual", [] { return std::unique_ptr<NetworkBench>(new VirtualBench); }}),
    name_of_bench);

TEST(PosixNetwork, ASignalDoesNotEndAWait) {
  struct sigaction action {};
  action.sa_handler = [](int) {};
  struct sigaction before {};
  sigaction(SIGALRM, &action, &before);
  auto link = std::move(*PosixNetwork().open_datagrams({kLoopback, 0}));
  const itimerval soon{.it_interval = {}, .it_value = {.tv_sec = 0, .tv_usec = 5000}};
  setitimer(ITIMER_REAL, &soon, nullptr);
  const Nanoseconds begin = MonotonicClock::machine_time();
  EXPECT_FALSE(link->wait(30 * kMillisecond));
  EXPECT_GE(MonotonicClock::machine_time() - begin, 30 * kMillisecond);
  sigaction(SIGALRM, &before, nullptr);
}

TEST(Endpoint, IsReadAsPeopleWriteIt) {
  EXPECT_EQ(parse_endpoint("192.0.2.1:4000", 1), (Endpoint{0xC000'0201, 4000}));
  EXPECT_EQ(parse_endpoint("192.0.2.1", 1), (Endpoint{0xC000'0201, 1}));
  EXPECT_EQ(parse_endpoint(":7", 1), (Endpoint{kLoopback, 7}));
  EXPECT_EQ(parse_endpoint("", 1, 0), (Endpoint{0, 1}));
  EXPECT_EQ(parse_endpoint("localhost:7", 1), (Endpoint{kLoopback, 7}));
  EXPECT_EQ(to_string({0xC000'0201, 4000}), "192.0.2.1:4000");
  for (const char* wrong : {"robot", "1.2.3", "1.2.3.4.5", "256.1.1.1", "1.2.3.4:", "1.2.3.4:65536", "1.2.3.4:-1",
                            "1..2.3", "1.2.3.4:5:6", " 1.2.3.4", "-1.2.3.4"}) {
    const auto endpoint = parse_endpoint(wrong, 1);
    EXPECT_FALSE(endpoint) << wrong << " gave " << to_string(*endpoint);
  }
}

}  // namespace
}  // namespace takt::hw
