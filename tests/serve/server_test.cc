// A cell by HTTP: the guarantees of docs/remote.md.
#include "serve/server.h"

#include <chrono>
#include <set>

#include <fmt/format.h>

#include "app/cell.h"
#include "core/net/description.h"
#include "tests/serve/served.h"

namespace takt::serve::test {
namespace {

using namespace std::chrono_literals;

std::string first_code(const Answer& answer) {
  const Json json = answer.json();
  return json.contains("diagnostics") ? json["diagnostics"].at(0).value("code", "") : "";
}

TEST(Server, ARemoteRunInLockStepHasTheDigestOfTheLocalRun) {
  app::Cell local("scenarios/touch.json", {.models = {"models"}, .quiet = true});
  auto description = net::net_from_json(Served::motion());
  ASSERT_TRUE(description);
  const auto net = local.core().load(*description);
  ASSERT_TRUE(net) << net.error().to_string();
  ASSERT_NE(local.core().start(*net), 0u);
  const std::int64_t begin = local.core().cycle();
  local.wait(0.8);

  Served served(false);
  Client client = served.client();
  EXPECT_EQ(client.get("/v1/state").json()["cycle"], begin) << "time stands until somebody steps";
  client.take_lease();
  const int remote = client.load(Served::motion());
  ASSERT_EQ(client.state(remote), "Ready");
  ASSERT_EQ(client.post(fmt::format("/v1/nets/{}/start", remote)).status, 202);
  Answer stepped;
  for (int i = 0; i < 8; ++i) stepped = client.post("/v1/steps", {{"cycles", 100}});
  ASSERT_EQ(stepped.status, 200) << stepped.body;
  EXPECT_EQ(stepped.json()["cycle"], local.core().cycle());
  EXPECT_EQ(stepped.json()["digest"], to_string(local.core().digest().value()));
  EXPECT_NE(client.get("/v1/arms/arm").json()["state"]["q_commanded"],
            client.get("/v1/arms/arm").json()["data_sheet"]["home"])
      << "it has moved";
  (void)local.core().cancel(*net);
  (void)local.finish({});
}

TEST(Server, EveryDeviceHasADataSheetAndAState) {
  Served served(false, {}, "scenarios/screw.json");
  const Client client = served.client();
  const Json states = client.get("/v1/devices/state").json()["devices"];
  std::map<std::string, Json> sheets;
  int outputs = 0;
  const Json devices = client.get("/v1/devices").json()["devices"];
  for (const Json& device : devices) {
    const std::string name = device["name"], kind = device["kind"];
    EXPECT_EQ(device["reality"], "SIM") << name;
    EXPECT_TRUE(states.contains(name) || kind == "tool changer") << name;
    if (kind == "digital output") {
      EXPECT_EQ(states[name], (Json{{"value", false}, {"held", false}})) << name;
      ++outputs;
    }
    EXPECT_TRUE(sheets.try_emplace(name, device["data_sheet"]).second) << name << " twice";
  }
  for (const auto& [name, state] : states.items()) EXPECT_TRUE(sheets.contains(name)) << name;
  const Json& arm = sheets.at("arm");
  EXPECT_EQ(arm["joint_names"].size(), arm["velocity"].size());
  EXPECT_EQ(arm["modes"].at(0), "position");
  EXPECT_EQ(states["arm"], client.get("/v1/arms/arm").json()["state"]) << "time stands";
  EXPECT_GT(outputs, 0);
}

TEST(Server, ANetIsRejectedWithAllThatIsWrongWithIt) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const int net = client.load({{"name", "bad"},
                               {"primitives", {{{"id", "a"}, {"type", "Nonsense"}}, {{"id", "b"}, {"type", "Abs"}}}},
                               {"links", Json::array()}});
  const Json state = client.get(fmt::format("/v1/nets/{}", net)).json();
  EXPECT_EQ(state["state"], "Rejected");
  EXPECT_GE(state["diagnostics"].size(), 2u);
  EXPECT_EQ(client.get(fmt::format("/v1/nets/{}/report", net)).status, 409);
  const Answer malformed = client.post("/v1/nets", {{"net", {{"name", 3}}}, {"nonsense", 1}});
  EXPECT_EQ(malformed.status, 422);
  EXPECT_EQ(malformed.headers.at("Content-Type"), "application/problem+json");
  EXPECT_GE(malformed.json()["diagnostics"].size(), 2u);
}

TEST(Server, LifeOfANetAndItsEventsInOrder) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const int net = client.load(Served::motion());
  const int request = client.post(fmt::format("/v1/nets/{}/start", net)).json()["request"];
  (void)client.post("/v1/steps", {{"cycles", 50}});
  EXPECT_EQ(client.state(net), "Running");
  EXPECT_EQ(client.ask("DELETE", fmt::format("/v1/nets/{}", net)).status, 409) << "it is active";
  (void)client.post(fmt::format("/v1/nets/{}/cancel", net));
  (void)client.post("/v1/steps", {{"cycles", 2000}});
  EXPECT_EQ(client.state(net), "Terminated");
  EXPECT_EQ(client.get(fmt::format("/v1/nets/{}", net)).json()["cause"], "cancelled");
  EXPECT_TRUE(client.get(fmt::format("/v1/nets/{}/report", net)).json().contains("reactions"));

  std::vector<std::string> seen;
  std::int64_t from = 1, expected = 1;
  for (Json page = client.get("/v1/events?most=1").json(); !page["events"].empty();
       page = client.get(fmt::format("/v1/events?from={}&most=1", from)).json()) {
    const Json& event = page["events"].at(0);
    EXPECT_EQ(event["sequence"], expected++);
    EXPECT_FALSE(page["lost"]);
    from = page["next"];
    if (event["kind"] == "done" && event["request"] == request) seen.emplace_back("started");
    if (event["kind"] == "state" && event["net"] == net) seen.push_back(event["state"]);
  }
  EXPECT_EQ(seen.back(), "Terminated");
  EXPECT_NE(std::ranges::find(seen, "started"), seen.end());
  EXPECT_LT(std::ranges::find(seen, "Running"), std::ranges::find(seen, "Canceling"));
  EXPECT_EQ(client.ask("DELETE", fmt::format("/v1/nets/{}", net)).status, 200);
  (void)client.post("/v1/steps", {{"cycles", 1}});
  EXPECT_EQ(client.get(fmt::format("/v1/nets/{}", net)).status, 404);
}

TEST(Server, ARuleStartsANetWhenAnotherOneHasEnded) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const Json brief = {
      {"name", "brief"},
      {"primitives", {{{"id", "end"}, {"type", "Termination"}, {"parameters", {{"condition", true}}}}}}};
  const int first = client.load(brief), second = client.load(brief);
  const Answer rule = client.post(
      "/v1/rules", {{"condition", {{{"net", first}, {"states", {"Terminated"}}}}}, {"action", {{"start", {second}}}}});
  ASSERT_EQ(rule.status, 202) << rule.body;
  (void)client.post("/v1/steps", {{"cycles", 5}});
  EXPECT_EQ(client.state(second), "Ready");
  (void)client.post(fmt::format("/v1/nets/{}/start", first));
  (void)client.post("/v1/steps", {{"cycles", 5}});
  EXPECT_EQ(client.state(second), "Terminated");
  const Answer wrong = client.post(
      "/v1/rules", {{"condition", {{{"net", first}, {"states", {"Runing"}}}, 3}}, {"action", Json::object()}});
  EXPECT_EQ(wrong.status, 422);
  EXPECT_EQ(wrong.json()["diagnostics"].size(), 2u) << wrong.body;
}

TEST(Server, TheSameKeyDoesItOnce) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  client.headers["Idempotency-Key"] = "first";
  const Answer first = client.post("/v1/nets", {{"net", Served::motion()}});
  const Answer again = client.post("/v1/nets", {{"net", Served::motion()}});
  EXPECT_EQ(first.body, again.body);
  EXPECT_EQ(client.get("/v1/nets").json()["nets"].size(), 1u);
  EXPECT_EQ(client.post("/v1/nets", {{"net", Json::object()}}).status, 422);
}

TEST(Server, ACommandThatComesTooLateDoesNothing) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const int net = client.load(Served::motion());
  (void)client.post("/v1/steps", {{"cycles", 10}});
  EXPECT_EQ(client.post(fmt::format("/v1/nets/{}/start", net), {{"expires_at_cycle", 5}}).status, 409);
  (void)client.post("/v1/steps", {{"cycles", 10}});
  EXPECT_EQ(client.state(net), "Ready");
}

TEST(Server, OnlyTheHolderCommandsAndAnybodyStops) {
  Served served(false);
  Client holder = served.client(), other = served.client();
  holder.take_lease();
  const int net = holder.load(Served::motion());
  const std::string start = fmt::format("/v1/nets/{}/start", net);
  EXPECT_EQ(other.post(start).status, 400);
  other.fence = 99;
  EXPECT_EQ(other.post(start).status, 409);
  EXPECT_EQ(other.post("/v1/lease").status, 409);
  EXPECT_EQ(holder.post(start).status, 202);
  (void)holder.post("/v1/steps", {{"cycles", 100}});
  other.fence = 0;
  EXPECT_EQ(other.post("/v1/stop").status, 200);
  (void)holder.post("/v1/steps", {{"cycles", 1}});
  EXPECT_EQ(holder.get(fmt::format("/v1/nets/{}", net)).json()["cause"], "aborted");
  other.take_lease({{"take_over", true}});
  EXPECT_EQ(holder.post("/v1/nets", {{"net", Served::motion()}}).status, 409) << "the lease has changed hands";
}

TEST(Server, ASilentClientsMotionComesToRestInRealTime) {
  Served served(true);
  Client client = served.client();
  const Json motion = Served::motion();  // planned before the lease: silence counts from it on
  client.take_lease({{"cycles", 400}});
  const int net = client.load(motion);
  const Answer started = client.post(fmt::format("/v1/nets/{}/start", net));
  ASSERT_EQ(started.status, 202) << started.body;
  const auto patience = std::chrono::steady_clock::now() + 20s;
  while (client.state(net) != "Terminated" && std::chrono::steady_clock::now() < patience)
    std::this_thread::sleep_for(5ms);  // it looks, and says nothing
  const Json state = client.get(fmt::format("/v1/nets/{}", net)).json();
  EXPECT_EQ(state["cause"], "cancelled") << state;
  EXPECT_EQ(client.get("/v1/state").json()["holder"], 0);
  EXPECT_EQ(client.ask("PUT", "/v1/lease").status, 409);
  // What arms do is published after the states of nets.
  const auto arm_state = [&] { return client.get("/v1/arms/arm").json()["state"]; };
  while (!arm_state()["at_rest"].get<bool>() && std::chrono::steady_clock::now() < patience)
    std::this_thread::sleep_for(5ms);
  const Json arm = arm_state();
  EXPECT_TRUE(arm["at_rest"]);
  EXPECT_FALSE(arm["held"]);
}

TEST(Server, AWatchGivesEveryNthValue) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  Json net = {{"name", "count"},
              {"primitives",
               {{{"id", "wrist"}, {"type", "ForceTorqueSensor"}, {"parameters", {{"device", "wrist"}}}},
                {{"id", "end"}, {"type", "Termination"}, {"parameters", {{"condition", false}}}}}}};
  const int id = client.load(net);
  ASSERT_EQ(client.state(id), "Ready") << client.get(fmt::format("/v1/nets/{}", id)).body;
  const Answer made = client.post("/v1/watches", {{"net", id}, {"port", "wrist.wrench"}, {"every", 10}, {"keep", 100}});
  ASSERT_EQ(made.status, 201) << made.body;
  const std::string path = made.headers.at("Location");
  (void)client.post(fmt::format("/v1/nets/{}/start", id));
  (void)client.post("/v1/steps", {{"cycles", 101}});
  const Json read = client.get(path).json();
  ASSERT_GE(read["values"].size(), 9u);
  for (std::size_t i = 1; i < read["values"].size(); ++i)
    EXPECT_EQ(read["values"][i]["cycle"].get<int>() - read["values"][i - 1]["cycle"].get<int>(), 10);
  EXPECT_TRUE(read["newest"]["value"].contains("force"));
  EXPECT_EQ(client.post("/v1/watches", {{"net", id}, {"port", "wrist.wrnch"}}).status, 422);
  EXPECT_EQ(client.ask("DELETE", path).status, 200);
  EXPECT_EQ(client.get(path).status, 404);
}

TEST(Server, TheDescriptionNamesEveryRouteOnce) {
  Served served(false);
  const Json description = served.client().get("/v1/openapi.json").json();
  EXPECT_EQ(description["openapi"], "3.1.0");
  std::set<std::string> ids;
  for (const auto& [path, methods] : description["paths"].items())
    for (const auto& [method, operation] : methods.items()) {
      EXPECT_TRUE(ids.insert(operation["operationId"]).second) << path;
      if (method != "get" || path.find('{') != std::string::npos || !operation["responses"].contains("200")) continue;
      if (path.starts_with("/v1/program")) continue;  // WatchedRun.WhatIsDescribedOfAProgramIsThere
      const Answer answer = served.client().get(path);
      EXPECT_EQ(answer.status, 200) << path;
      for (const auto& key :
           operation["responses"]["200"]["content"]["application/json"]["schema"].value("required", Json::array()))
        EXPECT_TRUE(answer.json().contains(key.get<std::string>())) << path << " " << key;
    }
  EXPECT_GE(ids.size(), 20u);
}

TEST(Server, WhatIsNoGoodRequestGetsAProblem) {
  Served served(false, {.http = {.body_bytes = 10'000}});
  Client client = served.client();
  EXPECT_EQ(client.get("/v1/nothing").status, 404);
  const Answer method = client.ask("DELETE", "/v1/state");
  EXPECT_EQ(method.status, 405);
  EXPECT_EQ(method.headers.at("Allow"), "GET");
  EXPECT_EQ(client.get("/v1/events?form=1").status, 422);
  EXPECT_EQ(first_code(client.get("/v1/events?from=0")), "out-of-range");
  EXPECT_EQ(client.ask("POST", "/v1/lease", "{\"cycles\": 1, \"cycles\": 2}").status, 400);
  EXPECT_EQ(client.ask("POST", "/v1/lease", "[]").status, 422);
  EXPECT_EQ(client.ask("POST", "/v1/lease", std::string(20'000, ' ')).status, 413);
  Client foreign = served.client();
  foreign.headers["Host"] = "evil.example:80";
  EXPECT_EQ(foreign.get("/v1/state").status, 421);
  Client page = served.client();
  page.headers["Origin"] = "http://evil.example";
  EXPECT_EQ(page.get("/v1/state").status, 403);
  Client text = served.client();
  text.headers["Content-Type"] = "text/plain";
  EXPECT_EQ(text.post("/v1/lease").status, 415);
  EXPECT_TRUE(Wire(served.server->port(), "nonsense\r\n\r\n").read_all().starts_with("HTTP/1.1 400"));
  Client bloated = served.client();
  bloated.headers["X-Long"] = std::string(9000, 'x');
  EXPECT_EQ(bloated.get("/v1/state").status, 431);
}

TEST(Server, TokensSayWhoMayLookAndWhoCommands) {
  Server::Options options;
  options.tokens = {{Role::kObserver, "olga", "observer-token-1"}, {Role::kOperator, "otto", "operator-token-1"}};
  Served served(false, options);
  Client client = served.client();
  EXPECT_EQ(client.get("/v1/state").status, 401);
  client.headers["Authorization"] = "Bearer operator-token-2";
  EXPECT_EQ(client.get("/v1/state").status, 401);
  client.headers["Authorization"] = "Bearer observer-token-1";
  EXPECT_EQ(client.get("/v1/state").status, 200);
  EXPECT_EQ(client.post("/v1/lease").status, 403);
  EXPECT_EQ(client.post("/v1/stop").status, 200) << "everybody may stop";
  client.headers["Authorization"] = "Bearer operator-token-1";
  client.take_lease();
  Server::Options open;
  open.http.address = "0.0.0.0";
  const auto refused = Server::open(*served.cell, open);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().list().front().code, Code::kRequires);
}

TEST(Server, ManyConnectionsCostThemselvesOnly) {
  Served served(false, {.http = {.connections = 8, .request_time = 300ms}});
  {
    std::vector<std::unique_ptr<Wire>> silent;
    for (int i = 0; i < 8; ++i) silent.push_back(std::make_unique<Wire>(served.server->port(), "GET /v1/sta"));
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(served.client().get("/v1/state").status, 503);
    EXPECT_EQ(served.client().post("/v1/stop").status, 200) << "STOP is never refused";
    std::this_thread::sleep_for(800ms);
    EXPECT_EQ(served.client().get("/v1/state").status, 200) << "who is slow has lost its connection";
  }
  for (int i = 0; i < 1000; ++i) Wire dropped(served.server->port());
  Answer answer;
  for (int i = 0; i < 100 && answer.status != 200; ++i) {
    std::this_thread::sleep_for(10ms);
    answer = served.client().get("/v1/state");
  }
  EXPECT_EQ(answer.status, 200);
}

}  // namespace
}  // namespace takt::serve::test
