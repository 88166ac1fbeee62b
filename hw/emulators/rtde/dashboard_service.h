#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "hw/emulators/rtde/controller.h"
#include "hw/emulators/rtde/session.h"

namespace takt::hw::rtde {

/// Port 29999: a line for each command, a line for each answer.
class DashboardService final : public Service {
 public:
  static constexpr std::string_view kGreeting = "Connected: Universal Robots Dashboard Server\n";

  /// `controller` outlives the service and its sessions.
  explicit DashboardService(Controller& controller);
  std::unique_ptr<Session> open() override;

  /// The answer to a command, without its end of line.
  [[nodiscard]] std::string answer(std::string_view line);

 private:
  class Client;
  /// A command begins with these words; what follows is its argument.
  struct Command {
    std::string words;
    bool has_argument = false;
    std::function<std::string(const std::string& argument)> run;
  };

  void add(std::string words, std::function<std::string()> run);
  void add_with_argument(std::string words, std::function<std::string(const std::string&)> run);
  void add_state_commands();
  void add_power_commands();
  void add_program_commands();
  void add_message_commands();
  void add_e_series_commands();
  [[nodiscard]] std::string load(const std::string& path);
  [[nodiscard]] std::string program_state() const;

  Controller& controller_;
  std::vector<Command> commands_;
  std::string role_ = "PROGRAMMER", operational_mode_ = "NONE";
};

}  // namespace takt::hw::rtde
