// Any bytes to every interface of a UR controller, and to the driver's ends of them: nothing ends the process, nothing
// grows without bound, and what has been cut differently means the same.
#include <memory>
#include <string>
#include <string_view>

#include "core/device/device_file.h"
#include "hw/emulators/rtde/dashboard_service.h"
#include "hw/emulators/rtde/rtde_service.h"
#include "hw/emulators/rtde/script_service.h"
#include "hw/rtde/client.h"
#include "hw/rtde/dashboard_client.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"

namespace takt {
namespace {

using namespace hw::rtde;  // NOLINT

/// A controller with clients, which lives for one input.
struct Emulated {
  Emulated() : controller({}, arm()) {}
  static std::shared_ptr<const device::ArmDescription> arm() {
    static const auto read = device::read_arm("models/ur5").value();
    return read;
  }
  void frames(int count) {
    PlantSample plant{arm()->home, JointVector::Zero(6), JointVector::Zero(6), arm()->home};
    for (int i = 0; i < count; ++i) {
      controller.run_frame(plant);
      for (const auto& session : sessions) session->end_frame();
    }
  }
  Controller controller;
  RtdeService service{controller};
  DashboardService dashboard{controller};
  ScriptService scripts{controller, ScriptService::Stream::kPrimary, true};
  std::vector<std::unique_ptr<Session>> sessions;
};

/// The answers to a stream, whole or in two pieces.
std::string answers(Service& service, std::string_view bytes, std::size_t cut) {
  const auto session = service.open();
  session->receive(bytes.substr(0, cut));
  session->receive(bytes.substr(cut));
  return session->out();
}

void load_rtde(Emulated& emulated, std::string_view bytes) {
  const std::size_t cut = bytes.size() / 2;
  test::demand(answers(emulated.service, bytes, cut) == answers(emulated.service, bytes, bytes.size()),
               "a stream means the same however it is cut");
  emulated.sessions.push_back(emulated.service.open());
  emulated.sessions.back()->receive(bytes);
  emulated.frames(3);
  test::demand(emulated.sessions.back()->out().size() < 64 * kLargestPackage,
               "a client that does not read is not waited for");
}

void load_client(std::string_view bytes) {
  ClientRequest request;
  request.outputs = {"timestamp"};
  request.inputs = {{"input_int_register_24"}};
  Client client(request);
  client.begin();
  (void)client.receive(bytes);
  test::demand(client.state() != Client::State::kRefused || client.problems().has_errors(), "a refusal has a reason");
  DashboardClient dashboard;
  dashboard.ask("robotmode");
  dashboard.receive(bytes);
  (void)dashboard.take_out();
}

void load_script(Emulated& emulated, std::string_view bytes) {
  const auto session = emulated.scripts.open();
  session->receive(bytes);
  session->receive("\nend\n");
  (void)emulated.controller.programs().start(bytes);
  emulated.frames(2);
}

void load(std::string_view input) {
  if (input.empty()) return;
  Emulated emulated;
  const std::string_view bytes = input.substr(1);
  switch (input[0] % 4) {
    case 0:
      return load_rtde(emulated, bytes);
    case 1:
      return load_client(bytes);
    case 2:
      return load_script(emulated, bytes);
    default:
      (void)answers(emulated.dashboard, bytes, bytes.size() / 2);
  }
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{
      .words = {"timestamp", "actual_q", "input_int_register_24", "def p():", "end",
                "while True:", "movej([0,0,0,0,0,0])", "servoj(", "thread t():", "run t()", "sync()", "power on",
                "robotmode", "p[0,0,0,0,0,0]", "global ", "read_input_float_register(", "speedl(", "force_mode("},
      .load = load,
      .share = 0.0,
      .mutate = [](std::string_view, Random&) -> std::optional<std::string> { return std::nullopt; }};
  return target;
}

}  // namespace takt::test
