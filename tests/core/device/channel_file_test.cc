#include "core/device/channel_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace takt::test {
namespace {

using device::ChannelDescription;
using Json = nlohmann::ordered_json;
using testing::HasSubstr;

TEST(ChannelFile, ReadsAllThatAChannelCanSay) {
  Diagnostics diagnostics;
  const Json json = {{"type", "Wrench"},   {"writer", "net"},
                     {"unit", "N,N*m"},    {"frame", "flange"},
                     {"timeout_s", 0.004}, {"initial", {{"force", {1, 2, 3}}, {"torque", {0, 0, 0}}}}};
  const ChannelDescription channel = device::channel_from_json("felt", json, "/channels/felt", diagnostics);
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  EXPECT_EQ(channel.name, "felt");
  EXPECT_EQ(channel.type, net::ValueType::kWrench);
  EXPECT_EQ(channel.writer, ChannelDescription::Writer::kNet);
  EXPECT_EQ(channel.unit, "N,N*m");
  EXPECT_EQ(channel.frame, "flange");
  EXPECT_EQ(channel.timeout, 4 * kMillisecond);
  EXPECT_EQ(std::get<net::Wrench>(*channel.initial).force.z(), 3.0);
}

TEST(ChannelFile, TheTypeIsEnough) {
  Diagnostics diagnostics;
  const ChannelDescription channel = device::channel_from_json("go", {{"type", "Boolean"}}, "", diagnostics);
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  EXPECT_EQ(channel.writer, ChannelDescription::Writer::kOutside);
  EXPECT_EQ(channel.timeout, 0);
  EXPECT_FALSE(channel.initial);
}

TEST(ChannelFile, WhatIsWrongIsSaidWithItsPlace) {
  const auto text = [](const Json& json) {
    Diagnostics diagnostics;
    (void)device::channel_from_json("x", json, "/channels/x", diagnostics);
    return diagnostics.to_string();
  };
  EXPECT_THAT(text({{"type", "Reel"}}), HasSubstr("/channels/x/type"));
  EXPECT_THAT(text({{"type", "Reel"}}), HasSubstr("Real"));
  EXPECT_THAT(text({{"type", "Real"}, {"writer", "me"}}), HasSubstr("/channels/x/writer"));
  EXPECT_THAT(text({{"type", "Real"}, {"initial", "fast"}}), HasSubstr("/channels/x/initial"));
  EXPECT_THAT(text({{"type", "Real"}, {"timeout_s", -1}}), HasSubstr("/channels/x/timeout_s"));
  EXPECT_THAT(text({{"type", "Real"}, {"unit", "parsec"}}), HasSubstr("/channels/x/unit"));
  EXPECT_THAT(text({{"type", "Real"}, {"timeot_s", 1}}), HasSubstr("timeout_s"));
}

}  // namespace
}  // namespace takt::test
