// Port 29999 of the emulated controller, and what its commands do.
#include "hw/emulators/rtde/dashboard_service.h"

#include "tests/hw/rtde/controller_bench.h"

namespace takt::hw::rtde {
namespace {

class Dashboard : public testing::Test {
 protected:
  std::string ask(std::string_view command) { return service.answer(command); }
  test::ControllerBench bench;
  DashboardService service{bench.controller};
};

TEST_F(Dashboard, GreetsAndAnswersLineByLine) {
  const auto session = service.open();
  EXPECT_EQ(std::exchange(session->out(), {}), "Connected: Universal Robots Dashboard Server\n");
  session->receive("robot");
  EXPECT_EQ(session->out(), "");
  session->receive("mode\r\nRUNNING\n\nquit\n");
  EXPECT_EQ(session->out(), "Robotmode: RUNNING\nProgram running: false\nDisconnected\n");
  EXPECT_TRUE(session->closing());
}

TEST_F(Dashboard, SaysWhatItIs) {
  EXPECT_EQ(ask("PolyscopeVersion"), "URSoftware 3.15.8.106339 (Jan 01 2024)");
  EXPECT_EQ(ask("version"), "3.15.8");
  EXPECT_EQ(ask("get robot model"), "UR5");
  EXPECT_EQ(ask("get serial number"), "20225500001");
  EXPECT_EQ(ask("is in remote control"), "true");
  EXPECT_EQ(ask("make coffee"), "could not understand: 'make coffee'");
  EXPECT_EQ(ask("setUserRole operator"), "Setting user role: operator");
  EXPECT_EQ(ask("getUserRole"), "OPERATOR");
  EXPECT_EQ(ask("setUserRole king"), "Failed setting user role: king");
}

TEST_F(Dashboard, ReportsAreMadeByEitherSeries) {
  EXPECT_EQ(ask("generate flight report system"), "Flight Report generated with id: 1");
  EXPECT_EQ(ask("generate support file /programs"), "Completed successfully: /programs/ur_support.zip");
}

TEST_F(Dashboard, PowerAndBrakes) {
  EXPECT_EQ(ask("power off"), "Powering off");
  EXPECT_EQ(ask("robotmode"), "Robotmode: POWER_OFF");
  EXPECT_EQ(ask("play"), "Failed to execute: play");
  EXPECT_EQ(ask("power on"), "Powering on");
  bench.seconds(1.0);
  EXPECT_EQ(ask("robotmode"), "Robotmode: IDLE");
  EXPECT_EQ(ask("brake release"), "Brake releasing");
  bench.seconds(1.0);
  EXPECT_EQ(ask("robotmode"), "Robotmode: RUNNING");
  (void)ask("power off");
  (void)ask("brake release");
  bench.seconds(2.0);
  EXPECT_EQ(ask("robotmode"), "Robotmode: RUNNING") << "it powers on by itself";
  EXPECT_EQ(ask("power on"), "Powering on");
  EXPECT_EQ(ask("robotmode"), "Robotmode: RUNNING");
}

TEST_F(Dashboard, Programs) {
  EXPECT_EQ(ask("get loaded program"), "Loaded program: /programs/takt.urp");
  EXPECT_EQ(ask("programState"), "STOPPED takt.urp");
  EXPECT_EQ(ask("play"), "Starting program");
  EXPECT_EQ(ask("running"), "Program running: true");
  EXPECT_EQ(ask("pause"), "Pausing program");
  EXPECT_EQ(ask("programState"), "PAUSED takt.urp");
  EXPECT_EQ(ask("play"), "Starting program");
  EXPECT_EQ(ask("programState"), "PLAYING takt.urp");
  EXPECT_EQ(ask("stop"), "Stopped");
  EXPECT_EQ(ask("pause"), "Failed to execute: pause");
  EXPECT_EQ(ask("load nothing.urp"), "File not found: nothing.urp");
  EXPECT_EQ(ask("load takt.urp"), "Loading program: takt.urp");
  EXPECT_EQ(ask("load installation default.installation"), "Loading installation: default.installation");
  EXPECT_EQ(ask("isProgramSaved"), "true takt.urp");
}

TEST_F(Dashboard, AProtectiveStopIsUnlockedAfterFiveSeconds) {
  bench.controller.protective_stop("test");
  EXPECT_EQ(ask("safetymode"), "Safetymode: PROTECTIVE_STOP");
  EXPECT_EQ(ask("robotmode"), "Robotmode: RUNNING");
  bench.seconds(4.9);
  EXPECT_TRUE(ask("unlock protective stop").starts_with("Cannot unlock protective stop until 5s"));
  bench.seconds(0.2);
  EXPECT_EQ(ask("unlock protective stop"), "Protective stop releasing");
  EXPECT_EQ(ask("safetystatus"), "Safetystatus: NORMAL");
}

TEST_F(Dashboard, AnEmergencyStopCutsThePower) {
  bench.controller.emergency_stop(true);
  bench.frame();
  EXPECT_EQ(ask("safetymode"), "Safetymode: ROBOT_EMERGENCY_STOP");
  EXPECT_EQ(ask("robotmode"), "Robotmode: POWER_OFF");
  (void)ask("power on");
  bench.seconds(2.0);
  EXPECT_EQ(ask("robotmode"), "Robotmode: POWER_OFF") << "while the button is pressed";
  bench.controller.emergency_stop(false);
  (void)ask("brake release");
  bench.seconds(2.0);
  EXPECT_EQ(ask("robotmode"), "Robotmode: RUNNING");
}

TEST_F(Dashboard, PopUps) {
  EXPECT_EQ(ask("popup hello there"), "showing popup");
  EXPECT_EQ(bench.controller.settings().popup, "hello there");
  EXPECT_EQ(ask("close popup"), "closing popup");
  EXPECT_EQ(ask("close safety popup"), "closing safety popup");
  EXPECT_EQ(ask("addToLog x"), "Added log message");
}

TEST(DashboardE, OperationalModesAreOfTheESeries) {
  test::ControllerBench bench(test::e_series());
  DashboardService service(bench.controller);
  EXPECT_EQ(service.answer("get operational mode"), "NONE");
  EXPECT_TRUE(service.answer("set operational mode manual").ends_with("is set"));
  EXPECT_EQ(service.answer("get operational mode"), "MANUAL");
  EXPECT_TRUE(service.answer("clear operational mode").starts_with("No longer controlling the operational mode."));
  test::ControllerBench cb3;
  EXPECT_TRUE(DashboardService(cb3.controller).answer("get operational mode").starts_with("could not understand"));
}

}  // namespace
}  // namespace takt::hw::rtde
