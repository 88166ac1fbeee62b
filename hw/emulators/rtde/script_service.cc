#include "hw/emulators/rtde/script_service.h"

#include <algorithm>
#include <array>

#include "hw/emulators/rtde/client_stream.h"

namespace takt::hw::rtde {

namespace {

constexpr int kStatesPerSecond = 10;
// Codes of error messages.
constexpr int kNotInRemoteControl = 210, kNotRunning = 211, kNoSimulation = 212;

void refuse_script(Controller& c, int code, std::string_view why) {
  c.events().add({.kind = ControllerEvent::Kind::kError,
                  .code = code,
                  .level = 2,
                  .title = {},
                  .text = std::string(why),
                  .time = c.time()});
}

void run_robot(Controller& c) {
  c.power().release_brakes();
  c.end_freedrive();
}

struct LineCommand {
  std::string_view words;
  void (*run)(Controller&);
};
constexpr std::array<LineCommand, 10> kLineCommands = {
    {{"stop program", [](Controller& c) { c.stop_program(); }},
     {"pause program", [](Controller& c) { c.programs().pause(); }},
     {"resume program", [](Controller& c) { (void)c.programs().resume(); }},
     {"power on", [](Controller& c) { c.power().power_on(); }},
     {"power off", [](Controller& c) { c.power_off(); }},
     {"set robotmode run", run_robot},
     {"set robotmode freedrive", [](Controller& c) { c.begin_freedrive(); }},
     {"set real", [](Controller&) {}},
     {"set sim",
      [](Controller& c) { refuse_script(c, kNoSimulation, "an emulated controller has no simulation mode"); }},
     {"set unlock protective stop", [](Controller& c) { c.power().unlock_later(); }}}};

std::string_view trimmed_line(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  while (line.starts_with(' ')) line.remove_prefix(1);
  return line;
}

/// "digital_out[2]=True", as before there were functions for it.
std::string without_arrays(std::string_view line) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 2> kArrays = {
      {{"digital_out[", "set_digital_out("}, {"analog_out[", "set_analog_out("}}};
  for (const auto& [array, function] : kArrays) {
    const std::size_t close = line.find(']'), equals = line.find('=');
    if (!line.starts_with(array) || close == std::string_view::npos || equals == std::string_view::npos ||
        equals < close)
      continue;
    std::string call(function);
    call += line.substr(array.size(), close - array.size());
    call += ", ";
    call += line.substr(equals + 1);
    return call + ")";
  }
  return std::string(line);
}

}  // namespace

void run_piece(Controller& controller, const ScriptIntake::Piece& piece) {
  const std::string_view line = trimmed_line(piece.text);
  const auto command = std::ranges::find(kLineCommands, line, &LineCommand::words);
  if (!piece.is_program && command != kLineCommands.end()) return command->run(controller);
  if (!controller.options().remote_control)
    return refuse_script(controller, kNotInRemoteControl, "scripts are accepted in remote control only");
  const bool secondary = piece.text.starts_with("sec ");
  if (!secondary && !controller.power().can_move())
    return refuse_script(controller, kNotRunning, "programs start only while the robot is running and not stopped");
  (void)controller.programs().start(piece.is_program ? piece.text : without_arrays(line) + "\n");
}

class ScriptService::Client final : public Session {
 public:
  Client(ScriptService& service) : service_(service), next_event_(service.controller_.events().end()) {
    if (service.stream_ != Stream::kRealtime) out() += make_version_message(controller());
  }

  void receive(std::string_view bytes) override {
    if (!service_.accepts_scripts_) return;
    intake_.feed(bytes);
    while (const auto piece = intake_.next()) run_piece(controller(), *piece);
  }

  void end_frame() override {
    if (service_.stream_ == Stream::kRealtime) {
      if (reads()) out() += make_realtime_state(controller());
      return;
    }
    if (service_.stream_ == Stream::kPrimary) send_events();
    const auto every = static_cast<std::uint64_t>(controller().options().version.frequency() / kStatesPerSecond);
    if (controller().frame() % every == 0) send_state();
  }

 private:
  [[nodiscard]] Controller& controller() const { return service_.controller_; }

  void send_state() {
    if (reads()) out() += make_robot_state(controller());
  }
  void send_events() {
    const EventLog& events = controller().events();
    next_event_ = std::max(next_event_, events.begin());
    for (; next_event_ < events.end(); ++next_event_) {
      const ControllerEvent& event = events[next_event_];
      // Clients compare the two.
      if (event.kind == ControllerEvent::Kind::kSafetyMode) send_state();
      if (reads()) out() += make_message(event);
    }
  }

  ScriptService& service_;
  ScriptIntake intake_;
  std::uint64_t next_event_;
};

std::unique_ptr<Session> ScriptService::open() { return std::make_unique<Client>(*this); }

}  // namespace takt::hw::rtde
