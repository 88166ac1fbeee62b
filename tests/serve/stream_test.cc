// Streams: events, monitors, tickets, broken messages, scene and pictures (docs/remote.md, "Streams").
#include <algorithm>
#include <cstring>
#include <set>
#include <thread>

#include <fmt/format.h>

#include "core/net/description.h"
#include "tests/serve/stream_client.h"

namespace takt::serve::test {
namespace {

using namespace std::chrono_literals;

const Json kBriefNet = {
    {"name", "brief"},
    {"primitives", {{{"id", "end"}, {"type", "Termination"}, {"parameters", {{"condition", true}}}}}}};

/// Makes at least so many state changes of nets, while time stands still for everybody else.
void change_states(const Served& served, std::int64_t count) {
  rcc::ControlCore& core = served.cell->core();
  const auto brief = net::net_from_json(kBriefNet);
  ASSERT_TRUE(brief);
  Client client = served.client();
  client.take_lease({{"take_over", true}});
  const std::int64_t until = served.cell->next_event() + count;
  while (served.cell->next_event() < until) {
    std::vector<rcc::NetId> nets;
    for (int i = 0; i < 200; ++i) {
      const auto net = core.load(*brief);
      ASSERT_TRUE(net) << net.error().to_string();
      ASSERT_NE(core.start(*net), 0u);
      nets.push_back(*net);
    }
    ASSERT_EQ(client.post("/v1/steps", {{"cycles", 3}}).status, 200);
    for (const rcc::NetId net : nets) ASSERT_TRUE(core.unload(net));
    ASSERT_EQ(client.post("/v1/steps", {{"cycles", 1}}).status, 200);
  }
}

/// Reads events until one has this number. @return where to go on
std::int64_t read_events(StreamClient& stream, std::int64_t expected, std::int64_t last, int& states) {
  while (expected <= last) {
    const Json page = stream.await("events");
    if (page.is_null()) {
      ADD_FAILURE() << "nothing comes after " << expected - 1;
      return expected;
    }
    for (const Json& event : page["events"]) {
      EXPECT_EQ(event["sequence"], expected++);
      states += event["kind"] == "state" ? 1 : 0;
    }
    EXPECT_EQ(page["next"], expected);
  }
  return expected;
}

/// The status with which a handshake is refused.
int refusal(const Served& served, const std::string& target, const std::map<std::string, std::string>& headers = {}) {
  Client client = served.client();
  client.headers = {{"Connection", "Upgrade"},
                    {"Upgrade", "websocket"},
                    {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="},
                    {"Sec-WebSocket-Version", "13"},
                    {"Sec-WebSocket-Protocol", "takt.v1"}};
  for (const auto& [name, value] : headers) client.headers[name] = value;
  return client.get(target).status;
}

TEST(Streams, ATicketIsGoodOnce) {
  Server::Options options;
  options.tokens = {{Role::kObserver, "olga", "observer-token-1"}};
  Served served(false, options);
  EXPECT_EQ(refusal(served, "/v1/stream"), 401);
  Client client = served.client();
  EXPECT_EQ(client.post("/v1/tickets").status, 401);
  client.headers["Authorization"] = "Bearer observer-token-1";
  const Json given = client.post("/v1/tickets").json();
  EXPECT_GT(given["seconds"], 0);
  const std::string target = "/v1/stream?ticket=" + given["ticket"].get<std::string>();
  StreamClient stream(served, target);
  ASSERT_EQ(stream.status(), 101);
  const Json hello = stream.await("hello");
  EXPECT_EQ(hello["name"], "olga");
  EXPECT_EQ(hello["role"], "observer");
  EXPECT_EQ(hello["next"], served.cell->next_event());
  EXPECT_EQ(refusal(served, target), 401) << "it was used";
  EXPECT_EQ(refusal(served, "/v1/stream?ticket=0123"), 401);
  EXPECT_EQ(StreamClient(served, "/v1/stream", "takt.v1", {{"Authorization", "Bearer observer-token-1"}}).status(),
            101);
}

TEST(Streams, OnlyWhoMayAskAndSpeaksTheProtocolGetsOne) {
  Served served(false);
  EXPECT_EQ(StreamClient(served).status(), 101);
  EXPECT_EQ(StreamClient(served, "/v1/stream", "takt.v0, takt.v1").status(), 101);
  EXPECT_EQ(refusal(served, "/v1/stream", {{"Sec-WebSocket-Protocol", ""}}), 426);
  EXPECT_EQ(refusal(served, "/v1/stream", {{"Sec-WebSocket-Protocol", "takt.v0"}}), 426);
  EXPECT_EQ(refusal(served, "/v1/state"), 404);
  EXPECT_EQ(refusal(served, "/v1/stream?tiket=1"), 422);
  EXPECT_EQ(refusal(served, "/v1/stream", {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(refusal(served, "/v1/stream", {{"Host", "evil.example"}}), 421);
  EXPECT_EQ(served.client().get("/v1/stream").status, 426);
  const Json description = served.client().get("/v1/openapi.json").json();
  EXPECT_GT(description["x-takt-messages"].size(), 10u);
}

TEST(Streams, TenThousandStateChangesReachASleepingReaderInOrder) {
  Served served(false);
  StreamClient stream(served);
  stream.send({{"op", "events"}, {"from", 1}});
  std::this_thread::sleep_for(20ms);
  change_states(served, 15'000);  // the reader sleeps
  const std::int64_t last = served.cell->next_event() - 1;
  int states = 0;
  const std::int64_t next = read_events(stream, 1, last / 2, states);
  stream.drop();
  StreamClient again(served);
  again.send({{"op", "events"}, {"from", next}});
  EXPECT_EQ(read_events(again, next, last, states), last + 1);
  EXPECT_GE(states, 10'000);
}

TEST(Streams, WhoIsTooLateIsToldWhereToGoOn) {
  Served served(false);
  change_states(served, static_cast<std::int64_t>(HostedCell::kEvents) + 1000);
  StreamClient stream(served);
  stream.send({{"op", "events"}, {"from", 1}});
  EXPECT_TRUE(stream.await("events").is_null());
  const auto [code, reason] = stream.close_reason();
  EXPECT_EQ(code, 4008);
  const std::int64_t oldest = served.cell->next_event() - static_cast<std::int64_t>(HostedCell::kEvents);
  EXPECT_EQ(reason, fmt::format("resume {}", oldest));
  StreamClient again(served);
  again.send({{"op", "events"}, {"from", oldest}});
  int states = 0;
  EXPECT_EQ(read_events(again, oldest, served.cell->next_event() - 1, states), served.cell->next_event());
}

TEST(Streams, AClientThatTakesNothingIsClosed) {
  Served served(false, {.http = {.silence = 400ms}});
  StreamClient stream(served);
  stream.send({{"op", "events"}, {"from", 1}});
  std::this_thread::sleep_for(20ms);
  change_states(served, 40'000);  // more than buffers of the system hold
  for (int i = 0; i < 300 && served.server->connections() > 0; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(served.server->connections(), 0u);
}

TEST(Streams, MonitorsShowValuesOfNetsAndArms) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const int net =
      client.load({{"name", "look"},
                   {"primitives",
                    {{{"id", "wrist"}, {"type", "ForceTorqueSensor"}, {"parameters", {{"device", "wrist"}}}},
                     {{"id", "end"}, {"type", "Termination"}, {"parameters", {{"condition", false}}}}}}});
  ASSERT_EQ(client.post(fmt::format("/v1/nets/{}/start", net)).status, 202);
  StreamClient stream(served);
  stream.send({{"op", "monitor"}, {"id", 7}, {"net", net}, {"port", "wrist.wrench"}});
  const Json monitored = stream.await("monitored");
  EXPECT_EQ(monitored["type"], "Wrench");
  EXPECT_EQ(monitored["every"], 1);
  stream.send({{"op", "monitor"}, {"id", 8}, {"arm", "arm"}, {"value", "q_measured"}});
  EXPECT_EQ(stream.await("monitored")["type"], "Joints");
  (void)client.post("/v1/steps", {{"cycles", 20}});
  std::optional<Frame> frame;
  for (std::uint32_t number = 1; !frame || frame->of(7) == nullptr; ++number) {
    frame = stream.frame();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->number, number);
    stream.send({{"op", "ack"}, {"frame", number}});
  }
  EXPECT_EQ(frame->kind, 1);
  EXPECT_EQ(frame->version, 1);
  EXPECT_EQ(frame->cycle, served.cell->core().cycle() - 1);
  const FrameEntry &wrench = *frame->of(7), &joints = *frame->of(8);
  EXPECT_EQ(wrench.type, 8);
  EXPECT_EQ(wrench.cycle, frame->cycle);
  EXPECT_EQ(wrench.numbers().size(), 6u);
  EXPECT_EQ(joints.type, 9);
  const auto q = client.get("/v1/arms/arm").json()["state"]["q_measured"].get<std::vector<double>>();
  EXPECT_EQ(joints.numbers(), q);
  (void)client.post(fmt::format("/v1/nets/{}/abort", net));
  (void)client.post("/v1/steps", {{"cycles", 5}});
  const Json ended = stream.await("ended");
  EXPECT_EQ(ended["id"], 7);
  EXPECT_EQ(ended["reason"], "net");
}

TEST(Streams, ASensorIsWatchedWithoutANet) {
  Served served(false);
  StreamClient stream(served);
  stream.send({{"op", "monitor"}, {"id", 1}, {"sensor", "wrist"}, {"every", 10}});
  EXPECT_EQ(stream.await("monitored")["type"], "Wrench");
  Client client = served.client();
  client.take_lease();
  (void)client.post("/v1/steps", {{"cycles", 20}});
  const auto frame = stream.frame();
  ASSERT_TRUE(frame);
  const FrameEntry* wrench = frame->of(1);
  ASSERT_NE(wrench, nullptr);
  EXPECT_EQ(wrench->type, 8);
  EXPECT_EQ(wrench->numbers().size(), 6u);
}

TEST(Streams, ASlowClientGetsFewerValuesAndTheNewest) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  StreamClient stream(served);
  stream.send({{"op", "window"}, {"frames", 2}});
  stream.send({{"op", "monitor"}, {"id", 0}, {"arm", "arm"}, {"value", "q_commanded"}});
  ASSERT_FALSE(stream.await("monitored").is_null());
  for (int i = 0; i < 10; ++i) ASSERT_EQ(client.post("/v1/steps", {{"cycles", 10}}).status, 200);
  ASSERT_TRUE(stream.frame());
  const auto second = stream.frame();
  ASSERT_TRUE(second);
  EXPECT_FALSE(stream.read(100ms)) << "two are on their way";
  stream.send({{"op", "ack"}, {"frame", 2}});
  const auto third = stream.frame();
  ASSERT_TRUE(third);
  EXPECT_EQ(third->number, 3u);
  EXPECT_EQ(third->cycle, served.cell->core().cycle() - 1) << "what was in between is not sent";
  EXPECT_GT(third->cycle, second->cycle + 10);
  stream.send({{"op", "ack"}, {"frame", 4}});
  EXPECT_EQ(stream.await("problem")["status"], 409) << "that frame was not sent";
}

TEST(Streams, TheRateOfAMonitorChanges) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  StreamClient stream(served);
  const auto frames_of = [&](int steps) {
    for (int i = 0; i < steps; ++i) EXPECT_EQ(client.post("/v1/steps", {{"cycles", 1}}).status, 200);
    int frames = 0;
    while (const auto message = stream.read(200ms)) {
      frames += message->binary ? 1 : 0;
      if (message->binary) stream.send({{"op", "ack"}, {"frame", read_frame(message->text).number}});
    }
    return frames;
  };
  stream.send({{"op", "window"}, {"frames", 64}});
  stream.send({{"op", "monitor"}, {"id", 3}, {"arm", "arm"}, {"value", "dq_measured"}, {"every", 20}});
  EXPECT_EQ(stream.await("monitored")["every"], 20);
  EXPECT_NEAR(frames_of(60), 3, 1);
  stream.send({{"op", "rate"}, {"id", 3}, {"every", 0}});
  EXPECT_EQ(stream.await("monitored")["every"], 0);
  EXPECT_EQ(frames_of(40), 0);
  stream.send({{"op", "rate"}, {"id", 3}, {"every", 2}});
  EXPECT_EQ(stream.await("monitored")["every"], 2);
  EXPECT_NEAR(frames_of(20), 10, 2);
  stream.send({{"op", "unmonitor"}, {"id", 3}});
  EXPECT_EQ(stream.await("ended")["reason"], "asked");
  EXPECT_EQ(frames_of(5), 0);
}

TEST(Streams, PosesAreThoseOfTheScene) {
  Served served(false);
  Client client = served.client();
  client.take_lease();
  const int net = client.load(Served::motion());
  (void)client.post(fmt::format("/v1/nets/{}/start", net));
  (void)client.post("/v1/steps", {{"cycles", 300}});
  const Json scene = client.get("/v1/scene").json();
  StreamClient stream(served);
  stream.send({{"op", "monitor"}, {"id", 1}, {"poses", true}});
  EXPECT_EQ(stream.await("monitored")["type"], "Poses");
  const auto frame = stream.frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->kind, 2);
  ASSERT_EQ(frame->moving.size(), scene["moving"].size());
  ASSERT_EQ(frame->commanded.size(), scene["commanded"].size());
  ASSERT_GT(frame->commanded.size(), 5u);
  const sim::World& world = *served.cell->built().world;
  double farthest = 0.0;
  for (std::size_t i = 0; i < frame->moving.size(); ++i) {
    const int body = scene["moving"][i];
    EXPECT_EQ(world.body(scene["bodies"][static_cast<std::size_t>(body)]["name"].get<std::string>()), body);
    const sim::Pose X = world.body_pose(body);
    const auto& pose = frame->moving[i];
    EXPECT_NEAR((X.translation() - Eigen::Vector3d(pose[0], pose[1], pose[2])).norm(), 0.0, 1e-5);
    const Eigen::Quaterniond q(pose[3], pose[4], pose[5], pose[6]);
    EXPECT_LT(q.angularDistance(Eigen::Quaterniond(X.linear())), 1e-3);
    const auto start = scene["bodies"][static_cast<std::size_t>(body)]["pose"].get<std::vector<double>>();
    farthest = std::max(farthest, (X.translation() - Eigen::Vector3d(start[0], start[1], start[2])).norm());
  }
  EXPECT_GT(farthest, 0.01) << "the arm has moved since the scene was described";
  const auto last =
      static_cast<std::size_t>(std::ranges::find(scene["moving"], scene["commanded"].back()) - scene["moving"].begin());
  ASSERT_LT(last, frame->moving.size());
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(frame->commanded.back()[k], frame->moving[last][k], 0.02);
}

TEST(Streams, TheSceneHasTheMeshesThatItNames) {
  Served served(false);
  const Client client = served.client();
  const Json scene = client.get("/v1/scene").json();
  EXPECT_EQ(scene["bodies"][0]["name"], "world");
  EXPECT_EQ(scene["bodies"][0]["parent"], -1);
  std::set<std::string> kinds;
  std::size_t used = 0;
  for (const Json& body : scene["bodies"])
    for (const Json& shape : body["shapes"]) {
      kinds.insert(shape["kind"]);
      EXPECT_EQ(shape["pose"].size(), 7u);
      EXPECT_EQ(shape["rgba"].size(), 4u);
      if (shape["kind"] == "mesh") used = std::max(used, shape["mesh"].get<std::size_t>() + 1);
    }
  EXPECT_TRUE(kinds.contains("mesh"));
  EXPECT_TRUE(kinds.contains("box"));
  ASSERT_EQ(scene["meshes"].size(), used);
  for (std::size_t i = 0; i < used; ++i) {
    const Answer mesh = client.get(fmt::format("/v1/scene/meshes/{}", i));
    EXPECT_EQ(mesh.headers.at("Content-Type"), "application/octet-stream");
    EXPECT_EQ(mesh.body.size(), scene["meshes"][i]["bytes"]);
    std::uint32_t vertices = 0, corner = 0;
    std::memcpy(&vertices, mesh.body.data(), 4);
    EXPECT_EQ(vertices, scene["meshes"][i]["vertices"]);
    std::memcpy(&corner, mesh.body.data() + mesh.body.size() - 4, 4);
    EXPECT_LT(corner, vertices);
  }
  EXPECT_EQ(client.get(fmt::format("/v1/scene/meshes/{}", used)).status, 404);
}

TEST(Streams, ACameraShowsWhatIsNow) {
  Served served(false);
  Client client = served.client();
  const Json cameras = client.get("/v1/scene").json()["cameras"];
  ASSERT_GE(cameras.size(), 2u);
  const auto path_of = [](const std::string& name) {
    return fmt::format("/v1/cameras/{}/picture?width=64&height=48", name);
  };
  const std::string path = path_of(cameras[0]);
  const auto picture = [&client](const std::string& at) {
    Answer answer = client.get(at);
    EXPECT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(answer.headers["Content-Type"], "image/png");
    return answer.body;
  };
  const std::string before = picture(path);
  ASSERT_TRUE(before.starts_with("\x89PNG"));
  EXPECT_EQ(before.substr(16, 8), std::string("\0\0\0\x40\0\0\0\x30", 8)) << "width and height";
  EXPECT_TRUE(picture(path) == before) << "nothing moves";
  EXPECT_TRUE(picture(path_of(cameras[1])) != before) << "another camera";
  EXPECT_TRUE(picture(path_of("overview")).starts_with("\x89PNG"));
  client.take_lease();
  (void)client.post(fmt::format("/v1/nets/{}/start", client.load(Served::motion())));
  (void)client.post("/v1/steps", {{"cycles", 1000}});
  EXPECT_TRUE(picture(path) != before) << "the arm has moved";
  EXPECT_EQ(client.get("/v1/cameras/nobody/picture").status, 404);
  EXPECT_EQ(client.get(path + "000").status, 422) << "48000 pixels";
}

TEST(Streams, PicturesComeWhileTheyAreTakenAndNeverOldOnes) {
  Served served(false);
  Client client = served.client();
  const std::string camera = client.get("/v1/scene").json()["cameras"][0];
  StreamClient stream(served);
  stream.send({{"op", "monitor"}, {"id", 4}, {"camera", camera}, {"width", 64}, {"height", 48}, {"every", 40}});
  EXPECT_EQ(stream.await("monitored")["type"], "Picture");
  const auto first = stream.frame();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, 3);
  EXPECT_TRUE(first->picture.starts_with("\x89PNG"));
  EXPECT_EQ(first->picture.substr(16, 8), std::string("\0\0\0\x40\0\0\0\x30", 8)) << "width and height";
  stream.send({{"op", "ack"}, {"frame", first->number}});
  client.take_lease();
  (void)client.post(fmt::format("/v1/nets/{}/start", client.load(Served::motion())));
  std::string last = first->picture;
  for (int i = 1; i <= 3; ++i) {
    (void)client.post("/v1/steps", {{"cycles", 400}});
    const auto next = stream.frame();
    ASSERT_TRUE(next) << i;
    // One that was wanted while the steps ran shows a state in between; never one from before them.
    EXPECT_GT(next->cycle, first->cycle + 400 * (i - 1)) << i;
    last = next->picture;
    stream.send({{"op", "ack"}, {"frame", next->number}});
  }
  EXPECT_TRUE(last != first->picture) << "the arm has moved";
  stream.send({{"op", "monitor"}, {"id", 5}, {"camera", "nobody"}, {"width", 8}});
  const Json refused = stream.await("problem");
  EXPECT_EQ(refused["status"], 422);
  EXPECT_EQ(refused["diagnostics"].size(), 2u) << refused;
  stream.send({{"op", "unmonitor"}, {"id", 4}});
  EXPECT_EQ(stream.await("ended")["reason"], "asked");
}

TEST(Streams, CamerasArePinholeCameras) {
  Served served(false);
  const Json cameras = served.client().get("/v1/cameras").json()["cameras"];
  ASSERT_FALSE(cameras.empty());
  for (const Json& camera : cameras)
    EXPECT_NEAR(std::atan(0.5 / camera["focal"].get<double>()), 0.5 * camera["fovy_rad"].get<double>(), 1e-12);
}

TEST(Streams, BrokenMessagesCloseOrAreRefused) {
  Served served(false);
  {
    StreamClient stream(served);
    const std::vector<std::pair<Json, int>> refused = {
        {{{"op", "monitr"}}, 422},
        {{{"nonsense", 1}}, 422},
        {{{"op", 3}}, 422},
        {{{"op", "monitor"}, {"id", -1}, {"poses", true}}, 422},
        {{{"op", "monitor"}, {"id", 1}}, 422},
        {{{"op", "monitor"}, {"id", 1}, {"poses", true}, {"arm", "arm"}}, 422},
        {{{"op", "monitor"}, {"id", 1}, {"poses", false}}, 422},
        {{{"op", "monitor"}, {"id", 1}, {"arm", "amr"}, {"value", "q_measured"}}, 422},
        {{{"op", "monitor"}, {"id", 1}, {"sensor", "wirst"}}, 422},
        {{{"op", "monitor"}, {"id", 1}, {"channel", "nothing"}}, 422},
        {{{"op", "monitor"}, {"id", 1}, {"net", 77}, {"port", "a.b"}}, 422},
        {{{"op", "rate"}, {"id", 1}, {"every", 1}}, 404},
        {{{"op", "unmonitor"}, {"id", 1}}, 404},
        {{{"op", "window"}, {"frames", 0}}, 422},
        {{{"op", "events"}, {"from", 0}}, 422},
        {{{"op", "move"}, {"jog", 1}, {"sequence", 1}, {"rates", {0}}}, 409},
        {{{"op", "unjog"}, {"jog", 1}}, 409}};
    for (const auto& [message, status] : refused) {
      stream.send(message);
      const Json problem = stream.await("problem");
      EXPECT_EQ(problem["status"], status) << message.dump() << problem.dump();
    }
  }
  const auto closes = [&served](const std::string& text, bool binary, int code) {
    StreamClient stream(served);
    ASSERT_FALSE(stream.await("hello").is_null());
    stream.send_text(text, binary);
    EXPECT_FALSE(stream.read()) << text.substr(0, 20);
    EXPECT_EQ(stream.close_reason().first, code) << text.substr(0, 20);
  };
  closes("{\"op\": ", false, 1007);
  closes("[1]", false, 1008);
  closes("\xff\xfe", false, 1007);
  closes("{}", true, 1003);
  closes(std::string(70'000, ' '), false, 1009);
  closes(std::string(5'000, '['), false, 1007);
  EXPECT_EQ(served.client().get("/v1/state").status, 200);
}

}  // namespace
}  // namespace takt::serve::test
