// The client's end of RTDE: set-up against the emulated server, and everything that a controller may refuse.
#include "hw/rtde/client.h"

#include <gmock/gmock.h>

#include "hw/emulators/rtde/rtde_service.h"
#include "hw/rtde/dashboard_client.h"
#include "tests/hw/rtde/controller_bench.h"

namespace takt::hw::rtde {
namespace {

ClientRequest usual() {
  ClientRequest request;
  request.outputs = {"timestamp", "actual_q", "robot_mode"};
  request.optional_outputs = {"payload", "ft_raw_wrench"};
  request.inputs = {{"input_int_register_24", "input_double_register_24"}, {"speed_slider_mask"}};
  return request;
}

/// Both ends, as far as they have something to say; `piece` bytes at a time.
void exchange(Client& client, Session& server, std::size_t piece = 1000) {
  for (int i = 0; i < 20; ++i) {
    server.receive(std::exchange(client.out(), {}));
    std::string answer = std::exchange(server.out(), {});
    for (std::size_t at = 0; at < answer.size(); at += piece) (void)client.receive(answer.substr(at, piece));
  }
}

TEST(RtdeClient, SetsUpReadsAndWrites) {
  for (const std::size_t piece : {std::size_t{1}, std::size_t{3}, std::size_t{1000}}) {
    test::ControllerBench bench;
    RtdeService service(bench.controller);
    const auto server = service.open();
    bench.sessions = {server.get()};
    Client client(usual());
    client.begin();
    exchange(client, *server, piece);
    ASSERT_EQ(client.state(), Client::State::kRunning) << client.problems().to_string();
    EXPECT_EQ(client.version(), bench.controller.options().version);
    EXPECT_TRUE(client.has_optional(0));
    EXPECT_FALSE(client.has_optional(1)) << "a CB3 has no such sensor";
    bench.frame();
    EXPECT_EQ(client.receive(std::exchange(server->out(), {})), 1);
    EXPECT_NEAR(client.values()[0][0], to_seconds(bench.controller.time()), 1e-9);
    EXPECT_EQ(client.values()[1][1], test::ur5()->home[1]);
    EXPECT_EQ(client.values()[2][0], 7.0);
    client.send(0, {FieldValue{-5.0}, FieldValue{0.25}});
    server->receive(std::exchange(client.out(), {}));
    EXPECT_EQ(bench.controller.inputs().ints[24], -5);
    EXPECT_EQ(bench.controller.inputs().reals[24], 0.25);
  }
}

/// Answers of a controller, one after the other.
struct Fake {
  explicit Fake(ClientRequest request = usual()) : client(std::move(request)) { client.begin(); }
  void say(PackageType type, std::string_view payload) { (void)client.receive(make_package(type, payload)); }
  void accept_protocol() { say(PackageType::kProtocolVersion, "\1"); }
  void version(const Version& version) { (void)client.receive(encode_version(version)); }
  void setup(PackageType type, int id, std::string_view words) {
    (void)client.receive(encode_setup_reply(type, static_cast<std::uint8_t>(id), words, true));
  }
  [[nodiscard]] std::string refusal() const {
    return client.state() == Client::State::kRefused ? client.problems().to_string() : "not refused";
  }
  Client client;
};

using testing::HasSubstr;

TEST(RtdeClient, AnUnknownProtocolIsRefusedAfterBoth) {
  Fake fake;
  fake.say(PackageType::kProtocolVersion, std::string_view("\0", 1));
  EXPECT_EQ(fake.client.state(), Client::State::kSettingUp) << "it asks for version 1";
  fake.say(PackageType::kProtocolVersion, std::string_view("\0", 1));
  EXPECT_THAT(fake.refusal(), HasSubstr("neither version 2 nor version 1"));
}

TEST(RtdeClient, VersionsThatItDoesNotKnowAreRefused) {
  for (const Version& version : {Version{4, 0, 0, 0}, Version{3, 3, 9, 0}, Version{0, 0, 0, 0}}) {
    Fake fake;
    fake.accept_protocol();
    fake.version(version);
    EXPECT_THAT(fake.refusal(), HasSubstr("has software " + to_string(version)));
  }
}

TEST(RtdeClient, FieldsThatAreMissingOrBusyAreNamedWithWhatToDo) {
  Fake fake;
  fake.accept_protocol();
  fake.version({3, 8, 0, 0});
  fake.setup(PackageType::kSetupInputs, 0, "NOT_FOUND,IN_USE");
  EXPECT_THAT(fake.refusal(),
              HasSubstr("no field 'input_int_register_24' (Update the controller (the field came with 3.9.0)"));
  EXPECT_THAT(fake.refusal(), HasSubstr("another client writes the input 'input_double_register_24'"));
}

TEST(RtdeClient, TypesThatAreNotAsKnownAreRefused) {
  Fake fake;
  fake.accept_protocol();
  fake.version({3, 15, 8, 0});
  fake.setup(PackageType::kSetupInputs, 1, "DOUBLE,DOUBLE");
  EXPECT_THAT(fake.refusal(),
              HasSubstr("'input_int_register_24' is DOUBLE (Check the version of the controller: INT32 is expected)"));
}

TEST(RtdeClient, AnswersThatCannotBeAreRefused) {
  for (const std::string_view words : {"INT32", "", "INT32,DOUBLE,DOUBLE"}) {
    Fake fake;
    fake.accept_protocol();
    fake.version({3, 15, 8, 0});
    fake.setup(PackageType::kSetupInputs, 1, words);
    EXPECT_EQ(fake.client.state(), Client::State::kRefused) << words;
  }
  Fake fake;
  fake.accept_protocol();
  fake.version({3, 15, 8, 0});
  fake.setup(PackageType::kSetupInputs, 0, "INT32,DOUBLE");
  EXPECT_THAT(fake.refusal(), HasSubstr("refuses the list of fields"));
  Fake stranger;
  (void)stranger.client.receive("HTTP/1.1 400 Bad Request\r\n\r\n");
  (void)stranger.client.receive(std::string("\0\0\0", 3));
  Fake broken;
  (void)broken.client.receive(std::string("\0\1x", 3));
  EXPECT_THAT(broken.refusal(), HasSubstr("no RTDE packages"));
}

TEST(RtdeClient, ForeignPackagesAreCountedAndDoNoHarm) {
  Fake fake;
  fake.say(PackageType::kStart, "\1");
  fake.say(PackageType::kData, "x");
  (void)fake.client.receive(encode(TextMessage{TextMessage::Level::kInfo, "hello", "x"}, 2));
  EXPECT_EQ(fake.client.state(), Client::State::kSettingUp);
  EXPECT_EQ(fake.client.misshapen(), 1u);
  EXPECT_EQ(fake.client.take_messages().size(), 1u);
  fake.accept_protocol();
  fake.version({3, 15, 8, 0});
  fake.setup(PackageType::kSetupInputs, 1, "INT32,DOUBLE");
  fake.setup(PackageType::kSetupInputs, 2, "UINT32");
  fake.setup(PackageType::kSetupOutputs, 1, "DOUBLE,VECTOR6D,INT32,DOUBLE");
  fake.say(PackageType::kStart, "\1");
  ASSERT_EQ(fake.client.state(), Client::State::kRunning) << fake.client.problems().to_string();
  fake.say(PackageType::kData, std::string(10, '\1'));
  fake.say(PackageType::kData, std::string(200, '\1'));
  EXPECT_EQ(fake.client.misshapen(), 3u);
  EXPECT_EQ(fake.client.values()[0][0], 0.0);
}

TEST(DashboardClient, OneQuestionAtATime) {
  DashboardClient client;
  client.ask("robotmode");
  client.ask("version");
  EXPECT_EQ(client.take_out(), "") << "not before the greeting";
  client.receive("Connected: x\n");
  EXPECT_EQ(client.take_out(), "robotmode\n");
  EXPECT_EQ(client.take_out(), "") << "not before the answer";
  client.receive("Robotmode: RUN");
  EXPECT_FALSE(client.next_answer());
  client.receive("NING\r\nunasked\n");
  const auto answer = client.next_answer();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->command, "robotmode");
  EXPECT_EQ(answer->text, "Robotmode: RUNNING");
  EXPECT_FALSE(client.next_answer());
  EXPECT_EQ(client.take_out(), "version\n");
  client.receive("URSoftware 3.15.8\n");
  EXPECT_EQ(client.take_out(), "") << "nothing more was asked";
}

TEST(DashboardClient, ALineThatIsTooLongIsCutOff) {
  DashboardClient client;
  client.receive("Connected: x\n");
  client.ask("version");
  ASSERT_EQ(client.take_out(), "version\n");
  for (int i = 0; i < 100; ++i) client.receive(std::string(1000, 'v'));
  client.receive("\nnext\n");
  const auto answer = client.next_answer();
  ASSERT_TRUE(answer);
  EXPECT_LT(answer->text.size(), 10'000u);
  EXPECT_EQ(answer->text.find_first_not_of('v'), std::string::npos);
  EXPECT_FALSE(client.next_answer());
}

}  // namespace
}  // namespace takt::hw::rtde
