#include "serve/watched_run.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "serve/server.h"
#include "tests/serve/served.h"

namespace takt::serve::test {
namespace {

using State = ProgramDesk::State;
constexpr const char* kFile = "scenarios/touch.json";

const device::ModelLibrary& library() {
  static const device::ModelLibrary models({"models"});
  return models;
}

/// A program that runs in a thread, watched and served.
class Watched {
 public:
  explicit Watched(bool realtime = false, const std::string& file = kFile) {
    options.realtime = realtime;
    options.repeat = false;
    cell::OpenOptions opening;
    opening.realtime = realtime;
    auto opened = cell::Session::open(file, library(), opening);
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().to_string());
    session = std::move(*opened);
    run = std::make_unique<WatchedRun>(*session, options);
    server = std::move(*Server::open(*run, {}));
  }
  ~Watched() {
    if (thread_.joinable()) run->stop_all("the end of the test");
    join();
    server.reset();
  }
  void begin() {
    thread_ = std::thread([this] {
      report = session->run(options);
      run->ended(report);
    });
  }
  void join() {
    if (thread_.joinable()) thread_.join();
  }
  void await(State state) const {
    for (int i = 0; i < 2000 && run->program()->view().state != state; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(name_of(run->program()->view().state), name_of(state));
  }
  [[nodiscard]] Client client() const { return {.port = server->port()}; }
  [[nodiscard]] ProgramDesk& desk() const { return *run->program(); }

  cell::RunOptions options;
  std::unique_ptr<cell::Session> session;
  std::unique_ptr<WatchedRun> run;
  std::unique_ptr<Server> server;
  cell::RunReport report;

 private:
  std::thread thread_;
};

std::string digest_unwatched(std::int64_t cycles) {
  auto session = cell::Session::open(kFile, library());
  cell::RunOptions options;
  options.repeat = false;
  options.after_cycle = [cycles](cell::BuiltCell& built) { return built.core->cycle() < cycles; };
  return (*session)->run(options).digest;
}

TEST(WatchedRun, NothingMovesBeforeSomebodyStartsItAndThenItIsTheRunOfItsFile) {
  Watched watched;
  constexpr std::int64_t kCycles = 1500;
  watched.options.after_cycle = [before = watched.options.after_cycle](cell::BuiltCell& built) {
    return before(built) && built.core->cycle() < kCycles;
  };
  watched.begin();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  watched.await(State::kAwaitsStart);
  const std::int64_t cycle = watched.run->view().cycle;
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(watched.run->view().cycle, cycle);
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(watched.client().post("/v1/program/start").status, 200);
  watched.join();
  EXPECT_GT(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(1400 - cycle));
  EXPECT_EQ(watched.report.digest, digest_unwatched(kCycles));
}

TEST(WatchedRun, GoesStepByStepPausesAndChangesItsSpeed) {
  Watched watched;
  watched.begin();
  watched.await(State::kAwaitsStart);
  EXPECT_EQ(watched.client().post("/v1/program/pause").status, 409);  // it has not begun
  EXPECT_EQ(watched.client().post("/v1/program/step").status, 200);
  watched.await(State::kAwaitsStep);
  EXPECT_FALSE(watched.desk().view().next.name.empty());
  EXPECT_EQ(watched.client().post("/v1/program/start").status, 200);
  watched.await(State::kRuns);
  EXPECT_EQ(watched.client().ask("PUT", "/v1/program/speed", R"({"share": 0.5})").status, 200);
  EXPECT_EQ(watched.client().ask("PUT", "/v1/program/speed", R"({"share": 2})").status, 422);
  EXPECT_EQ(watched.client().post("/v1/program/pause").status, 200);
  watched.await(State::kPaused);
  const auto at_rest = [&] { return watched.run->view().arms.front().at_rest; };
  for (int i = 0; i < 1000 && !at_rest(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_TRUE(at_rest());
  const Json program = watched.client().get("/v1/program").json();
  EXPECT_EQ(program["state"], "paused");
  EXPECT_EQ(program["speed"], 0.5);
  EXPECT_FALSE(program["running"].empty());
  EXPECT_EQ(watched.client().post("/v1/program/cancel").status, 200);
  watched.join();
  EXPECT_EQ(watched.client().get("/v1/program").json()["state"], "ended");
  EXPECT_EQ(watched.client().post("/v1/program/start").status, 409);
}

TEST(WatchedRun, StopEndsTheProgramEvenWhileTheTimeStands) {
  Watched watched;
  watched.begin();
  watched.await(State::kAwaitsStart);
  EXPECT_EQ(watched.client().post("/v1/stop").status, 200);
  watched.join();
  EXPECT_NE(watched.report.verdict, cell::Verdict::kPassed);
}

TEST(WatchedRun, NobodyElseCommandsAndItsTreeIsThatOfTheFile) {
  Watched watched;
  EXPECT_EQ(watched.client().post("/v1/lease", {{"devices", {"arm"}}}).status, 409);
  const Json tree = watched.client().get("/v1/program/tree").json();
  ASSERT_EQ(tree["steps"].size(), 1u);
  EXPECT_EQ(tree["steps"][0]["name"], "measure the block");
  EXPECT_EQ(tree["steps"][0]["steps"][0]["pointer"], "/program/steps/0");
  EXPECT_TRUE(watched.client().get("/v1/state").json()["program"].get<bool>());
}

TEST(WatchedRun, OneClientAtATimeWritesTheChannelsOfTheProgramAndNothingElse) {
  Watched watched(false, "scenarios/lessons/18-channels.json");
  Client first = watched.client(), second = watched.client();
  const std::string path = "/v1/channels/enabled";
  EXPECT_EQ(first.ask("PUT", path, R"({"value": null})").status, 400) << "without a fence";
  first.take_lease();
  EXPECT_EQ(first.ask("PUT", path, R"({"value": null})").status, 200);
  EXPECT_EQ(first.ask("PUT", path, R"({"value": null, "expires_at_cycle": 0})").status, 409) << "too late";
  EXPECT_EQ(first.post("/v1/nets", {{"net", Json::object()}}).status, 409) << "devices are the program's";
  EXPECT_EQ(second.post("/v1/lease").status, 409) << "somebody has it";
  second.take_lease({{"take_over", true}});
  EXPECT_EQ(first.ask("PUT", path, R"({"value": null})").status, 409);
  EXPECT_EQ(second.ask("PUT", path, R"({"value": null})").status, 200);
}

TEST(WatchedRun, ALayoutBesideTheFileIsHandedOutAndABrokenOneIsReported) {
  const std::filesystem::path folder = testing::TempDir() + "layouts";
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(kFile, folder / "cell.json", std::filesystem::copy_options::overwrite_existing);
  std::filesystem::remove(folder / "cell.layout");
  Watched watched(false, (folder / "cell.json").string());
  const auto layout = [&](const std::string& text) {
    if (!text.empty()) std::ofstream(folder / "cell.layout") << text;
    return watched.client().get("/v1/layout").json();
  };
  EXPECT_TRUE(layout("")["layout"].is_null());
  EXPECT_TRUE(layout("")["diagnostics"].empty());
  const std::string good = R"({"columns": [{"panes": [{"show": "force", "sensor": "wrist", "max_N": 20}]}]})";
  EXPECT_EQ(layout(good)["layout"], Json::parse(good));
  const Json broken = layout(R"({"columns": [{"wide": 1, "panes": [
      {"show": "force", "sensor": "wirst", "max_N": 20}, {"show": "view4d"}]}]})");
  EXPECT_TRUE(broken["layout"].is_null());
  ASSERT_EQ(broken["diagnostics"].size(), 3u) << broken;
  EXPECT_FALSE(layout("{")["diagnostics"].empty());
}

TEST(WatchedRun, WhatIsDescribedOfAProgramIsThere) {
  Watched watched;
  const Json description = watched.client().get("/v1/openapi.json").json();
  int looked = 0;
  for (const auto& [path, methods] : description["paths"].items()) {
    if (!path.starts_with("/v1/program") || !methods.contains("get")) continue;
    const Answer answer = watched.client().get(path);
    EXPECT_EQ(answer.status, 200) << path;
    const Json& schema = methods["get"]["responses"]["200"]["content"]["application/json"]["schema"];
    for (const auto& key : schema["required"]) EXPECT_TRUE(answer.json().contains(key.get<std::string>())) << path;
    ++looked;
  }
  EXPECT_EQ(looked, 3);
}

TEST(WatchedRun, InRealTimeItIsHeldUntilSomebodyStartsItAndHasNoSingleSteps) {
  Watched watched(true);
  watched.begin();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  watched.await(State::kAwaitsStart);
  EXPECT_TRUE(watched.desk().view().running.empty());
  EXPECT_EQ(watched.client().post("/v1/program/step").status, 409);
  EXPECT_EQ(watched.client().post("/v1/program/start").status, 200);
  watched.await(State::kRuns);
  for (int i = 0; i < 1000 && watched.desk().view().running.empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_FALSE(watched.desk().view().running.empty());
}

TEST(ServedCell, AServerWithoutAProgramSaysSoAndShowsItsSensors) {
  const Served served(true);
  served.await_connection();
  EXPECT_EQ(served.client().get("/v1/program").status, 404);
  const Json state = served.client().get("/v1/state").json();
  EXPECT_EQ(state["reality"], "SIM");
  EXPECT_FALSE(state["program"].get<bool>());
  EXPECT_TRUE(state["faults"].empty());
  const Json scene = served.client().get("/v1/scene").json();
  ASSERT_EQ(scene["sensors"].size(), 1u);
  EXPECT_EQ(scene["sensors"][0]["name"], "wrist");
  EXPECT_FALSE(scene["frames"].empty());
}

TEST(ServedCell, ANetIsAGraph) {
  const Served served(false);
  served.await_connection();
  Client client = served.client();
  client.take_lease();
  const int net = client.load(Served::motion());
  const Json graph = client.get("/v1/nets/" + std::to_string(net) + "/graph").json();
  ASSERT_FALSE(graph["primitives"].empty());
  const std::size_t count = graph["primitives"].size();
  for (const Json& link : graph["links"]) {
    EXPECT_LT(link["from"].get<std::size_t>(), count);
    EXPECT_LT(link["to"].get<std::size_t>(), count);
  }
  EXPECT_EQ(client.get("/v1/nets/99999/graph").status, 404);
}

}  // namespace
}  // namespace takt::serve::test
