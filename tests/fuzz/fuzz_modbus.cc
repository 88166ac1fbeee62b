// Any bytes between a coupler on Modbus TCP and its driver leave both alive; what can be read is written as it was; a
// stream means the same however it is cut. The first byte of an input says to whom the rest is sent.
#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

#include "hw/modbus/twin.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/support/fake_signals.h"

namespace takt {
namespace {

using namespace hw::modbus;  // NOLINT
using Kind = device::IoChannel::Kind;

std::shared_ptr<const device::IoDescription> described_block() {
  auto io = std::make_shared<device::IoDescription>();
  io->channels = {test::fake_channel(Kind::kDigitalInput, "di"), test::fake_channel(Kind::kDigitalOutput, "do"),
                  test::fake_channel(Kind::kAnalogInput, "ai", 0.0, 10.0),
                  test::fake_channel(Kind::kAnalogOutput, "ao", 0.0, 10.0)};
  return io;
}

struct Terminals {
  Terminals() {
    all.digital_inputs["di"] = std::make_shared<test::FakeInput<bool>>();
    all.analog_inputs["ai"] = std::make_shared<test::FakeInput<double>>();
    all.digital_outputs["do"] = std::make_shared<test::FakeOutput<bool>>();
    all.analog_outputs["ao"] = valve;
  }
  std::shared_ptr<test::FakeOutput<double>> valve = std::make_shared<test::FakeOutput<double>>();
  device::IoTerminals all;
};

std::vector<Frame> frames_of(std::string_view bytes, std::size_t cut) {
  FrameParser parser;
  std::vector<Frame> frames;
  for (const std::string_view piece : {bytes.substr(0, cut), bytes.substr(cut)}) {
    parser.feed(piece);
    while (auto frame = parser.next()) frames.push_back(std::move(*frame));
  }
  return frames;
}

void expect_the_same(std::string_view bytes) {
  const auto whole = frames_of(bytes, 0);
  for (const std::size_t cut : {bytes.size() / 3, bytes.size() / 2, bytes.size()}) {
    const auto pieces = frames_of(bytes, cut);
    test::demand(pieces.size() == whole.size(), "a stream means the same however it is cut");
    for (std::size_t i = 0; i < whole.size(); ++i) test::demand(pieces[i].pdu == whole[i].pdu, "as before");
  }
}

void expect_written_as_read(std::string_view pdu) {
  const auto request = parse_request(pdu);
  if (!request) return;
  const std::string again = encode(*request);
  const auto back = parse_request(again);
  test::demand(back && back->address == request->address && back->values == request->values,
               "what was read is written as it was");
  test::demand(again.size() <= kLargestPdu, "what is written is no longer than a frame");
}

/// Requests of the input, each in a frame of its own.
std::string framed(std::string_view bytes) {
  std::string out;
  std::uint16_t transaction = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t size = std::min<std::size_t>(1 + static_cast<std::uint8_t>(bytes[at]) % 16, bytes.size() - at);
    append_frame(out, {++transaction, 1, std::string(bytes.substr(at, size))});
    at += size;
  }
  return out;
}

void disturb_coupler(std::string_view bytes) {
  VirtualClock clock;
  hw::VirtualNetwork network(clock, 1);
  Terminals terminals;
  Coupler coupler({}, described_block(), network, terminals.all);
  (void)coupler.listen({hw::kLoopback, kPort});
  auto link = *network.connect({hw::kLoopback, kPort});
  std::vector<std::byte> sink(65'536);
  for (int k = 0; k < 20; ++k) {
    clock.set(k * kMillisecond);
    coupler.advance(clock.now());
    if (k == 5) (void)link->send(std::as_bytes(std::span(bytes)));
    (void)link->receive(sink);
  }
  const bool inside = terminals.valve->written.back() >= 0.0;
  test::demand(inside && std::isfinite(terminals.valve->written.back()), "an output is told finite numbers");
}

void disturb_driver(std::string_view bytes) {
  VirtualClock clock;
  hw::VirtualNetwork network(clock, 1);
  auto listener = *network.listen({hw::kLoopback, kPort});
  const auto io = described_block();
  hw::CycleImage image(*io);
  Client client({}, {"io", io, kMillisecond, 1}, image, network, clock);
  std::unique_ptr<hw::StreamLink> link;
  std::vector<std::byte> sink(65'536);
  for (int k = 0; k < 60; ++k) {
    clock.set(k * kMillisecond);
    client.poll();
    if (k == 40) client.reset();
    if (auto next = listener->accept()) link = std::move(next);
    if (link && k % 10 == 5) (void)link->send(std::as_bytes(std::span(bytes)));
    if (link) (void)link->receive(sink);
    image.look(0);
    test::demand(std::isfinite(image.inputs().analog[0]), "samples are finite");
  }
  test::demand(client.news().size() <= 64, "what is told does not grow without bound");
}

void load_bytes(std::string_view input) {
  if (input.empty()) return;
  const std::string_view bytes = input.substr(1);
  expect_written_as_read(bytes);
  const std::string dressed = input[0] % 2 == 0 ? std::string(bytes) : framed(bytes);
  expect_the_same(dressed);
  (input[0] / 2) % 2 == 0 ? disturb_coupler(dressed) : disturb_driver(dressed);
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  using namespace std::string_literals;
  static const FuzzTarget target{.words = {"\0\1\0\0\0\6\1"s, "\1\0\0\0\1"s, "\2\0\0\0\1"s, "\4\0\0\0\1"s,
                                           "\5\0\0\xFF\0"s, "\x0F\0\0\0\1\1\1"s, "\x10\0\0\0\1\2\0\1"s, "\x82\2"s},
                                 .load = load_bytes,
                                 .share = 0.0,
                                 .mutate = [](std::string_view, Random&) -> std::optional<std::string> { return {}; }};
  return target;
}

}  // namespace takt::test
