// Properties over random nets: order, neutrality, round trips. The comparison with the plain reading is a proof of its
// own, tests/proofs/compiled_net_equals_reference.cc.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/json.h"
#include "tests/core/net/net_support.h"
#include "tests/core/net/random_net.h"

namespace takt::net {
namespace {

constexpr int kCycles = 12;

Cycle cycle_number(std::int64_t index) {
  Cycle cycle;
  cycle.index = index;
  cycle.time = index * cycle.period;
  return cycle;
}

std::map<std::string, std::string> outputs(const CompiledNet& net) {
  std::map<std::string, std::string> all;
  for (const auto& port : net.ports()) {
    if (port.name.find(" > ") != std::string::npos) continue;
    visit_type(port.type, [&]<class T>(std::type_identity<T>) {
      const auto* slot = static_cast<const Slot<T>*>(net.find_slot(port.name, port.type));
      const auto* bytes = reinterpret_cast<const unsigned char*>(&slot->value);
      std::string text;
      for (std::size_t i = 0; i < sizeof(T) && slot->null == 0; ++i) text += fmt::format("{:02x}", bytes[i]);
      all[port.name] = slot->null != 0 ? "null" : text;
    });
  }
  return all;
}

TEST(RandomNets, RowO1OrderOfDeclarationChangesNoBit) {
  for (int seed = 0; seed < 300; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "orders");
    const NetDescription description = random_net(random, 30);
    const auto one = make_net(description), other = make_net(shuffled(description, random));
    ASSERT_EQ(one->report().order, other->report().order);
    for (int i = 0; i < kCycles; ++i) {
      one->evaluate(cycle_number(i));
      other->evaluate(cycle_number(i));
      ASSERT_TRUE(std::ranges::equal(one->slots(), other->slots())) << "seed " << seed << " cycle " << i;
    }
  }
}

TEST(RandomNets, AnUnconnectedPrimitiveChangesNoOutputBit) {
  for (int seed = 0; seed < 200; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "neutral");
    NetDescription description = random_net(random, 20);
    const auto without = make_net(description);
    description.add(fmt::format("{}-new", static_cast<char>('a' + seed % 26)), "TestSum", {{"in", 1.0}});
    const auto with = make_net(description);
    for (int i = 0; i < kCycles; ++i) {
      without->evaluate(cycle_number(i));
      with->evaluate(cycle_number(i));
    }
    const auto more = outputs(*with);
    for (const auto& [name, text] : outputs(*without)) ASSERT_EQ(more.at(name), text) << name << " seed " << seed;
  }
}

TEST(RandomNets, LoadOfDumpIsTheNet) {
  for (int seed = 0; seed < 300; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "dump");
    const NetDescription description = random_net(random, 25);
    const auto document = parse_json(net_to_json(description).dump());
    ASSERT_TRUE(document.has_value());
    const auto again = net_from_json(*document);
    ASSERT_TRUE(again.has_value()) << again.error().to_string();
    ASSERT_TRUE(*again == description) << net_to_json(description).dump(1) << net_to_json(*again).dump(1);
  }
}

/// Whatever stands in a file: Ready or Rejected with reasons, never a crash. Bytes of good nets are broken at random.
TEST(RandomNets, AnyBytesAreReadyOrRejected) {
  int ready = 0, rejected = 0;
  for (int seed = 0; seed < 3000; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "bytes");
    std::string text = net_to_json(random_net(random, 12)).dump();
    const int edits = static_cast<int>(random.bits() % 6);
    for (int i = 0; i < edits; ++i) {
      const std::size_t at = random.bits() % text.size();
      switch (random.bits() % 4) {
        case 0:
          text[at] = static_cast<char>(random.bits());
          break;
        case 1:
          text.erase(at, 1 + random.bits() % 20);
          break;
        case 2:
          text.insert(at, text.substr(random.bits() % text.size(), random.bits() % 60));
          break;
        default:
          text[at] = "0123456789abcdefghijklmnopqrstuvwxyz\"{}[],.:/-"[random.bits() % 46];
      }
      if (text.empty()) text = " ";
    }
    TestDevices devices;
    const auto document = parse_json(text);
    const auto description = document ? net_from_json(*document) : std::unexpected(document.error());
    const auto net = description ? CompiledNet::compile(*description, devices) : std::unexpected(description.error());
    if (net) {
      ++ready;
      for (int i = 0; i < 3; ++i) (*net)->evaluate(cycle_number(i));
    } else {
      ++rejected;
      ASSERT_TRUE(net.error().has_errors());
      for (const Diagnostic& diagnostic : net.error().list()) ASSERT_FALSE(diagnostic.message.empty());
    }
  }
  EXPECT_GT(ready, 300);
  EXPECT_GT(rejected, 300);
}

}  // namespace
}  // namespace takt::net
