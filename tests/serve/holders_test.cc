// Several clients on one cell: who commands what, how much each may ask for, and recordings.
#include "serve/holders.h"

#include <chrono>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "tests/serve/served.h"
#include "tests/support/scratch_folder.h"

namespace takt::serve::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* kScrew = "examples/activities/cells/screw.json";

std::string code_of(const Answer& answer) {
  const Json json = answer.json();
  return json.contains("diagnostics") ? json["diagnostics"].at(0).value("code", "") : "";
}

/// Switches an output on, until it is cancelled.
Json output_net(const std::string& device) {
  return {{"name", "on"},
          {"primitives",
           {{{"id", "out"}, {"type", "DigitalOutput"}, {"parameters", {{"device", device}, {"value", true}}}},
            {{"id", "end"}, {"type", "Termination"}, {"parameters", {{"condition", false}}}}}}};
}

/// Does nothing until it is cancelled.
Json idle_net() {
  return {{"name", "idle"},
          {"primitives", {{{"id", "end"}, {"type", "Termination"}, {"parameters", {{"condition", false}}}}}}};
}

TEST(HoldersTest, EachDeviceHasOneHolder) {
  std::vector<std::string> log;
  Server::Options options;
  options.log = [&log](const std::string& line) { log.push_back(line); };
  Served served(false, options, kScrew);
  Client anna = served.client(), bert = served.client();
  anna.take_lease({{"devices", {"arm"}}});
  bert.take_lease({{"devices", {"io/driver"}}});
  ASSERT_NE(anna.fence, 0u);
  ASSERT_NE(bert.fence, 0u);
  EXPECT_EQ(served.client().get("/v1/lease").json()["leases"].size(), 2u);

  const int foreign = anna.load(output_net("io/driver")), own = bert.load(output_net("io/driver"));
  ASSERT_EQ(bert.state(own), "Ready");
  const Answer refused = anna.post(fmt::format("/v1/nets/{}/start", foreign));
  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(code_of(refused), "conflict");
  const Answer by_rule = anna.post("/v1/rules", {{"action", {{"start", {foreign}}}}});
  EXPECT_EQ(by_rule.status, 409);
  EXPECT_EQ(anna.post("/v1/schedule", {{"predecessor", own}, {"successor", foreign}}).status, 409);

  EXPECT_EQ(bert.post(fmt::format("/v1/nets/{}/start", own)).status, 202);
  EXPECT_EQ(anna.post("/v1/steps", {{"cycles", 3}}).status, 200) << "time belongs to all of them";
  EXPECT_EQ(bert.state(own), "Running");
  EXPECT_EQ(anna.post(fmt::format("/v1/nets/{}/cancel", own)).status, 409) << "it is the net of somebody else";

  // Who takes the whole cell over ends both, and the log tells.
  Client carl = served.client();
  EXPECT_EQ(carl.post("/v1/lease").status, 409);
  carl.take_lease({{"take_over", true}});
  EXPECT_GT(carl.fence, bert.fence);
  ASSERT_EQ(carl.post("/v1/steps", {{"cycles", 5}}).status, 200);
  EXPECT_EQ(carl.state(own), "Canceling");
  EXPECT_EQ(bert.ask("PUT", "/v1/lease", "{}").status, 409);
  EXPECT_EQ(
      std::ranges::count_if(log, [](const auto& line) { return line.find("has lost the lease") != std::string::npos; }),
      2);
}

TEST(HoldersTest, NamesOfDevicesAreChecked) {
  Served served(false, {}, kScrew);
  const Answer unknown = served.client().post("/v1/lease", {{"devices", {"arm", "amr", "wrist"}}});
  EXPECT_EQ(unknown.status, 422);
  ASSERT_EQ(unknown.json()["diagnostics"].size(), 2u) << "all at once";
  EXPECT_EQ(unknown.json()["diagnostics"][0]["pointer"], "/devices/1");
  EXPECT_EQ(unknown.json()["diagnostics"][1]["pointer"], "/devices/2") << "nobody drives a sensor";
  EXPECT_EQ(served.client().post("/v1/lease", {{"devices", Json::array()}}).status, 422);
  EXPECT_TRUE(served.client().get("/v1/lease").json()["leases"].empty());
}

TEST(HoldersTest, RulesOfOneClientHaveAnEndAndStopHasNone) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const int first = client.load(idle_net()), second = client.load(idle_net());
  const Json rule = {{"condition", {{{"net", first}, {"states", {"Terminated"}}}}}, {"action", {{"start", {second}}}}};
  int taken = 0;
  Answer last;
  for (int i = 0; i < 100; ++i) {
    last = client.post("/v1/rules", rule);
    if (last.status != 202) break;
    ++taken;
  }
  EXPECT_EQ(taken, 64);
  EXPECT_EQ(last.status, 429);
  EXPECT_EQ(client.post("/v1/stop").status, 200);
  // What can never come true any more makes room.
  ASSERT_EQ(client.ask("DELETE", fmt::format("/v1/nets/{}", first)).status, 200);
  ASSERT_EQ(client.post("/v1/steps", {{"cycles", 3}}).status, 200);
  const int third = client.load(idle_net());
  EXPECT_EQ(client
                .post("/v1/rules", {{"condition", {{{"net", third}, {"states", {"Terminated"}}}}},
                                    {"action", {{"start", {second}}}}})
                .status,
            202);
}

TEST(HoldersTest, RequestsToOneCycleAndWatchesHaveAnEnd) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const int net = client.load(idle_net());
  int starts = 0;
  while (starts < 1000 && client.post(fmt::format("/v1/nets/{}/start", net)).status == 202) ++starts;
  EXPECT_EQ(starts, 256);
  EXPECT_EQ(client.post(fmt::format("/v1/nets/{}/abort", net)).status, 202) << "an abort needs no room";
  EXPECT_EQ(client.post("/v1/stop").status, 200);
  ASSERT_EQ(client.post("/v1/steps", {{"cycles", 1}}).status, 200);
  EXPECT_EQ(client.post(fmt::format("/v1/nets/{}/cancel", net)).status, 202) << "in the next cycle there is room";

  int watches = 0;
  while (watches < 100 && client.post("/v1/watches", {{"port", "arm.speed"}}).status == 201) ++watches;
  EXPECT_EQ(watches, 32);
}

TEST(RecordingTest, IsBegunSavedAndEndedByNetwork) {
  const takt::test::ScratchFolder scratch("recordings");
  const std::filesystem::path& folder = scratch.path();
  {
    Served served(false, {}, "scenarios/touch.json", folder.string());
    Client client = served.client();
    client.take_lease();
    EXPECT_EQ(client.get("/v1/recording").json()["state"], "off");
    EXPECT_EQ(client.ask("POST", "/v1/recording/save", "{}").status, 409) << "nothing is kept";

    ASSERT_EQ(client.ask("PUT", "/v1/recording", R"({"state": "on"})").status, 200);
    ASSERT_EQ(client.post("/v1/steps", {{"cycles", 200}}).status, 200);
    const Json ended = client.ask("PUT", "/v1/recording", R"({"state": "off"})").json();
    EXPECT_EQ(ended["state"], "off");
    ASSERT_EQ(ended["files"].size(), 1u);
    EXPECT_GT(std::filesystem::file_size(folder / ended["files"][0].get<std::string>()), 1000u);

    ASSERT_EQ(client.ask("PUT", "/v1/recording", R"({"state": "last", "seconds": 1})").status, 200);
    ASSERT_EQ(client.post("/v1/steps", {{"cycles", 3000}}).status, 200);
    const Answer saved = client.ask("POST", "/v1/recording/save", "{}");
    ASSERT_EQ(saved.status, 200) << saved.body;
    EXPECT_TRUE(std::filesystem::exists(folder / saved.json()["file"].get<std::string>()));
    EXPECT_EQ(client.get("/v1/recording").json()["state"], "last") << "it goes on";
    ASSERT_EQ(client.post("/v1/steps", {{"cycles", 10}}).status, 200);

    const Answer unknown = client.ask("PUT", "/v1/recording", R"({"state": "pause"})");
    EXPECT_EQ(unknown.status, 422);
    EXPECT_EQ(unknown.json()["diagnostics"][0]["pointer"], "/state");
    EXPECT_EQ(client.ask("PUT", "/v1/recording", R"({"state": "on", "file": "/etc/x"})").status, 422)
        << "no file name comes from a client";
  }
  int files = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) files += file.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, 2) << "what was only kept in memory is gone";
}

TEST(RecordingTest, IsRefusedWithoutAFolder) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const Answer refused = client.ask("PUT", "/v1/recording", R"({"state": "on"})");
  EXPECT_EQ(refused.status, 409);
  EXPECT_EQ(code_of(refused), "not-possible-now");
}

TEST(AccessTest, AnOriginIsSchemeHostAndPort) {
  for (const char* good : {"https://panel.example", "http://localhost:8080", "https://[::1]:8443", "http://192.0.2.7"})
    EXPECT_FALSE(check_origin("--origin", good).has_errors()) << good;
  for (const char* bad : {"nonsense", "", "https://", "https://a.b/", "https://a.b/page", "ftp://a.b", "https://A.b",
                          "https://a.b:0", "https://a.b:99999", "https://a.b:x", "https://user@a.b", "null", "*"}) {
    const Diagnostics wrong = check_origin("--origin", bad);
    ASSERT_TRUE(wrong.has_errors()) << bad;
    EXPECT_EQ(wrong.list().front().code, Code::kInvalidValue);
    EXPECT_EQ(wrong.list().front().pointer, "--origin");
  }
  const Diagnostics all = Server::check({.names = {"https://a.b", "fine"}, .origins = {"nonsense", "https://a.b"}});
  EXPECT_EQ(all.list().size(), 2u) << all.to_string();
}

}  // namespace
}  // namespace takt::serve::test
