#include "hw/emulators/rtde/dashboard_service.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

constexpr std::size_t kLongestCommand = 4096;

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string_view stripped(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.remove_suffix(1);
  return text;
}

std::string file_name(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

}  // namespace

class DashboardService::Client final : public Session {
 public:
  explicit Client(DashboardService& service) : service_(service) { out() += kGreeting; }

  void receive(std::string_view bytes) override {
    for (const char c : bytes) {
      if (c != '\n') {
        if (line_.size() < kLongestCommand) line_.push_back(c);
        continue;
      }
      const std::string command(stripped(std::exchange(line_, {})));
      if (command.empty()) continue;
      out() += service_.answer(command) + "\n";
      const std::string word = lower(command);
      if (word == "quit" || word == "shutdown") return close();
    }
  }

 private:
  DashboardService& service_;
  std::string line_;
};

DashboardService::DashboardService(Controller& controller) : controller_(controller) {
  add_state_commands();
  add_power_commands();
  add_program_commands();
  add_message_commands();
  if (controller.is_e_series()) add_e_series_commands();
}

std::unique_ptr<Session> DashboardService::open() { return std::make_unique<Client>(*this); }

std::string DashboardService::answer(std::string_view line) {
  const std::string text(stripped(line)), words = lower(text);
  // The longest that fits counts: "load installation X" is not "load" of a program.
  const Command* best = nullptr;
  for (const Command& command : commands_) {
    const bool same = words == command.words;
    const bool begins = command.has_argument && words.starts_with(command.words + " ");
    if ((same || begins) && (best == nullptr || command.words.size() > best->words.size())) best = &command;
  }
  if (best == nullptr) return fmt::format("could not understand: '{}'", text.substr(0, 80));
  return best->run(std::string(stripped(std::string_view(text).substr(best->words.size()))));
}

void DashboardService::add(std::string words, std::function<std::string()> run) {
  commands_.push_back({std::move(words), false, [run = std::move(run)](const std::string&) { return run(); }});
}
void DashboardService::add_with_argument(std::string words, std::function<std::string(const std::string&)> run) {
  commands_.push_back({std::move(words), true, std::move(run)});
}

void DashboardService::add_state_commands() {
  Controller& c = controller_;
  const ControllerOptions& options = c.options();
  add("polyscopeversion",
      [&] { return fmt::format("URSoftware {}.{} (Jan 01 2024)", to_string(options.version), options.version.build); });
  add("version", [&] { return to_string(options.version); });
  add("get serial number", [&] { return options.serial; });
  add("get robot model", [&] { return options.model; });
  add("is in remote control", [&] { return std::string(options.remote_control ? "true" : "false"); });
  add("robotmode", [&] { return fmt::format("Robotmode: {}", name_of(c.power().mode())); });
  add("safetymode", [&] { return fmt::format("Safetymode: {}", name_of(c.power().safety())); });
  add("safetystatus", [&] { return fmt::format("Safetystatus: {}", name_of(c.power().safety())); });
  add("quit", [] { return std::string("Disconnected"); });
  add("shutdown", [&] {
    c.power_off();
    return std::string("Shutting down");
  });
}

void DashboardService::add_power_commands() {
  Controller& c = controller_;
  add("power on", [&] {
    c.power().power_on();
    return std::string("Powering on");
  });
  add("power off", [&] {
    c.power_off();
    return std::string("Powering off");
  });
  add("brake release", [&] {
    c.power().release_brakes();
    return std::string("Brake releasing");
  });
  add("unlock protective stop", [&] {
    if (!c.power().unlock())
      return std::string(
          "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop "
          "before unlocking");
    return std::string("Protective stop releasing");
  });
  add("restart safety", [&] {
    c.power_off();
    c.power().restart_safety();
    return std::string("Restarting safety");
  });
}

void DashboardService::add_program_commands() {
  Programs& programs = controller_.programs();
  add_with_argument("load installation", [](const std::string& name) {
    return name.empty() ? std::string("Error while loading installation: ") : "Loading installation: " + name;
  });
  add_with_argument("load", [this](const std::string& path) { return load(path); });
  add("play", [this] { return std::string(controller_.play() ? "Starting program" : "Failed to execute: play"); });
  add("pause", [&] {
    if (!programs.running()) return std::string("Failed to execute: pause");
    programs.pause();
    return std::string("Pausing program");
  });
  add("stop", [this] {
    controller_.stop_program();
    return std::string("Stopped");
  });
  add("running", [&] {
    return fmt::format("Program running: {}", programs.state() == RuntimeState::kPlaying ? "true" : "false");
  });
  add("programstate", [this] { return program_state(); });
  add("get loaded program", [&] {
    return programs.loaded().empty() ? std::string("No program loaded") : "Loaded program: " + programs.loaded();
  });
  add("isprogramsaved", [&] { return "true " + file_name(programs.loaded()); });
}

std::string DashboardService::load(const std::string& path) {
  Programs& programs = controller_.programs();
  const std::string whole = path.starts_with('/') ? path : "/programs/" + path;
  switch (programs.load(whole)) {
    case Programs::Loading::kNotFound:
      return "File not found: " + path;
    case Programs::Loading::kInvalid:
      return "Error while loading program: " + path;
    case Programs::Loading::kLoaded:
      break;
  }
  return "Loading program: " + path;
}

std::string DashboardService::program_state() const {
  const RuntimeState state = controller_.programs().state();
  const std::string_view word = state == RuntimeState::kPlaying  ? "PLAYING"
                                : state == RuntimeState::kPaused ? "PAUSED"
                                                                 : "STOPPED";
  return fmt::format("{} {}", word, file_name(controller_.programs().loaded()));
}

void DashboardService::add_message_commands() {
  Controller& c = controller_;
  add_with_argument("popup", [&](const std::string& text) {
    c.settings().popup = text;
    return std::string("showing popup");
  });
  add("close popup", [&] {
    c.settings().popup.clear();
    return std::string("closing popup");
  });
  add("close safety popup", [] { return std::string("closing safety popup"); });
  add_with_argument("addtolog", [&](const std::string& text) {
    c.events().add({.title = {}, .text = text, .time = c.time()});
    return std::string("Added log message");
  });
  add_with_argument("generate flight report",
                    [](const std::string&) { return std::string("Flight Report generated with id: 1"); });
  add_with_argument("generate support file", [](const std::string& path) {
    return fmt::format("Completed successfully: {}/ur_support.zip", path);
  });
  add("savelog", [] { return std::string("Log saved to disk"); });
  if (c.is_e_series()) return;
  add_with_argument("setuserrole", [this](const std::string& role) {
    static constexpr std::array<std::string_view, 5> kRoles = {"programmer", "operator", "none", "locked",
                                                               "restricted"};
    if (std::ranges::find(kRoles, lower(role)) == kRoles.end()) return "Failed setting user role: " + role;
    role_ = role;
    std::ranges::transform(role_, role_.begin(), [](unsigned char ch) { return static_cast<char>(std::toupper(ch)); });
    return "Setting user role: " + role;
  });
  add("getuserrole", [this] { return role_; });
}

void DashboardService::add_e_series_commands() {
  add("get operational mode", [this] { return operational_mode_; });
  add_with_argument("set operational mode", [this](const std::string& mode) {
    if (lower(mode) != "manual" && lower(mode) != "automatic") return "Failed setting operational mode: " + mode;
    operational_mode_ = lower(mode) == "manual" ? "MANUAL" : "AUTOMATIC";
    return fmt::format("Operational mode '{}' is set", mode);
  });
  add("clear operational mode", [this] {
    operational_mode_ = "NONE";
    return std::string("No longer controlling the operational mode. Current operational mode: 'NONE'.");
  });
}

}  // namespace takt::hw::rtde
