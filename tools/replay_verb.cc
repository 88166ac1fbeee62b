// replay: a recorded run again, in any cycle, back and forth.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "cell/replay/time_travel.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

struct ReplayArguments {
  std::string recording, ports;
  std::optional<double> at;
  std::int64_t every = 1000;
  bool why = false, interactive = false;
};

constexpr const char* kHelp =
    "at S: to this time; cycle N: to this cycle; next [N], back [N]: so many cycles on or back\n"
    "ports [PATTERN]: values of ports, devices, simulation; why: the cancels that fired until now; end; q\n";

void tell_cycle(const Json& answer) {
  const bool equal = answer["digest_equal"].get<bool>();
  fmt::print(
      "{:9.3f} s  cycle {}  [{}]  {}\n", answer["time"].get<double>(), answer["cycle"].get<std::int64_t>(),
      answer["step"].get<std::string>(),
      equal ? "as recorded" : fmt::format("not as recorded from cycle {} on", answer["first_difference"].dump()));
  if (!answer["ended"].is_null()) fmt::print("  the run has ended: {}\n", answer["ended"].get<std::string>());
}

void tell_values(const std::string& of, const Json& values) {
  for (const auto& [name, value] : values.items()) fmt::print("  {}: {} = {}\n", of, name, value.dump());
}

void tell_ports(const Json& answer) {
  if (!answer.contains("nets")) return;
  for (const Json& net : answer["nets"]) {
    if (net["ports"].empty()) fmt::print("  net '{}'\n", net["name"].get<std::string>());
    tell_values(fmt::format("net '{}'", net["name"].get<std::string>()), net["ports"]);
  }
  if (!answer.contains("blocks")) return;
  for (const Json& block : answer["blocks"]) tell_values(block["name"].get<std::string>(), block["values"]);
}

void tell_why(const Json& answer) {
  if (!answer.contains("cancel_texts")) return;
  if (answer["cancel_texts"].empty()) fmt::print("no cancel has fired\n");
  for (const Json& text : answer["cancel_texts"]) fmt::print("{}", text.get<std::string>());
}

cell::TimeTravel::Question question(std::int64_t cycle, std::string ports = {}, bool why = false) {
  return {.cycle = cycle, .ports = std::move(ports), .why = why};
}

/// A person at the prompt.
class Prompt {
 public:
  explicit Prompt(cell::TimeTravel& travel) : travel_(travel) {}

  Diagnostics talk() {
    const bool terminal = isatty(STDIN_FILENO) != 0;
    if (terminal) fmt::print(stderr, "{}", kHelp);
    ask(question(0));
    for (std::string line; diagnostics_.list().empty();) {
      if (terminal) fmt::print(stderr, "> ");
      if (!std::getline(std::cin, line) || line == "q") break;
      obey(line);
    }
    return std::move(diagnostics_);
  }

 private:
  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb, argument;
    words >> verb >> argument;
    if (verb == "ports") return ask(question(cycle_, argument.empty() ? "*" : argument));
    if (verb == "why") return ask(question(cycle_, {}, true));
    if (verb == "end") return ask(question(travel_.cycles()));
    const auto number = number_of(argument);
    if (verb == "at" && number) return ask(question(std::llround(*number / kPeriod)));
    if (verb == "cycle" && number) return ask(question(static_cast<std::int64_t>(*number)));
    const auto steps = static_cast<std::int64_t>(number.value_or(1.0));
    if (verb == "next") return ask(question(cycle_ + steps));
    if (verb == "back") return ask(question(cycle_ - steps));
    fmt::print(stderr, "{}", kHelp);
  }

  static std::optional<double> number_of(const std::string& text) {
    double number = 0.0;
    std::istringstream words(text);
    constexpr double kMost = 1e12;
    if (!(words >> number) || std::abs(number) > kMost) return std::nullopt;
    return number;
  }

  void ask(cell::TimeTravel::Question question) {
    question.cycle = std::clamp<std::int64_t>(question.cycle, 0, travel_.cycles());
    const auto answer = travel_.ask(question);
    if (!answer) return diagnostics_.append(answer.error());
    cycle_ = question.cycle;
    tell_cycle(*answer);
    tell_ports(*answer);
    if (question.why) tell_why(*answer);
    std::fflush(stdout);
  }

  static constexpr double kPeriod = 1e-3;  // s
  cell::TimeTravel& travel_;
  std::int64_t cycle_ = 0;
  Diagnostics diagnostics_;
};

/// What is asked for on the command line, and the end: whether all of it was as recorded.
int once(const ReplayArguments& arguments, cell::TimeTravel& travel, const Common& common) {
  Json told = Json::object();
  const bool looks = arguments.at || !arguments.ports.empty();
  if (looks) {
    const auto cycle = static_cast<std::int64_t>(std::llround(arguments.at.value_or(0.0) * 1e3));
    const auto answer = travel.ask(
        {.cycle = std::min(cycle, travel.cycles() - 1), .ports = arguments.ports.empty() ? "*" : arguments.ports});
    if (!answer) return report(answer.error(), common);
    told = *answer;
    if (!common.json) tell_cycle(told), tell_ports(told);
  }
  const auto end = travel.ask(question(travel.cycles(), {}, arguments.why));
  if (!end) return report(end.error(), common);
  const bool equal = (*end)["digest_equal"].get<bool>();
  if (common.json) {
    Json json = {{"result", equal ? "passed" : "failed"}, {"cycles", travel.cycles()}, {"end", *end}};
    if (looks) json["at"] = told;
    print(json);
  } else {
    tell_cycle(*end);
    if (arguments.why) tell_why(*end);
  }
  return equal ? kHeld : kNotHeld;
}

int replay(const ReplayArguments& arguments, const Common& common) {
  if (arguments.interactive && (common.json || arguments.at || arguments.why || !arguments.ports.empty())) {
    Diagnostics diagnostics;
    diagnostics.error(Code::kConflict, "--interactive", "the prompt asks what to show", "Give --interactive alone");
    return report(diagnostics, common);
  }
  const auto recording = record::Recording::open(arguments.recording);
  if (!recording) return report(recording.error(), common);
  auto run = cell::ReopenedRun::open(*recording, common.library(), {});
  if (!run) return report(run.error(), common);
  auto travel = cell::TimeTravel::begin(*recording, *run, {.every = arguments.every});
  if (!travel) return report(travel.error(), common);
  if (!arguments.interactive) return once(arguments, *travel, common);
  const Diagnostics diagnostics = Prompt(*travel).talk();
  return diagnostics.has_errors() ? report(diagnostics, common) : kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_replay(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* verb = app.add_subcommand("replay", "Run a recorded run again, held against its digests, and look into it");
  verb->add_option("RECORDING", arguments->recording, "Recording (MCAP)")->required();
  verb->add_option("--at", arguments->at, "Show the state at the end of the cycle of this simulated time, s")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  verb->add_option("--ports", arguments->ports,
                   "Which ports and values, '*' stands for any characters; without --at those of the first cycle")
      ->type_name("PATTERN");
  verb->add_flag("--why", arguments->why, "Show why motions were cancelled: back to the samples");
  verb->add_flag("--interactive", arguments->interactive, "Ask what to show on stdin, back and forth");
  verb->add_option("--every", arguments->every, "Cycles from one snapshot to the next")
      ->type_name("N")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 40))
      ->capture_default_str();
  return {verb, [arguments, &common] { return replay(*arguments, common); }};
}

}  // namespace takt::tools
