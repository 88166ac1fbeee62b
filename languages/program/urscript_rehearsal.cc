#include "languages/program/urscript_rehearsal.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "languages/program/urscript_host.h"
#include "languages/program/urscript_steps.h"

namespace takt::languages {
namespace {

/// A line of a loop is played so often.
constexpr int kMostPlayedLines = 100;
/// Waits one after the other in which nothing is commanded, as of a loop that asks for an input.
constexpr int kMostIdleWaits = 2'000;
constexpr double kRehearsedCycle = 1e-3;  // s

class UrscriptRehearsal final : public UrscriptHost {
 public:
  UrscriptRehearsal(const std::string& file, const UrscriptMap& map, const program::Node& node,
                    operations::Rehearsal& rehearsal, Diagnostics& diagnostics)
      : UrscriptHost(map, rehearsal.cell, file),
        node_(node),
        rehearsal_(rehearsal),
        diagnostics_(diagnostics),
        parser_(rehearsal.cell, nullptr, unread_) {}

  void play(std::shared_ptr<const urscript::Program> program) {
    std::set<std::string> calls;
    for (const auto& [name, steps] : map_.calls) calls.insert(name);
    urscript::Session session(std::move(program), *this, calls, map_.given(cell_));
    using Progress = urscript::Session::Progress;
    Progress progress = Progress::kRunning;
    for (int idle = 0; idle < kMostIdleWaits && !ended_; ++idle) {
      progress = session.advance();
      if (!queue_.empty()) {
        play_next();
        idle = 0;
      } else if (progress == Progress::kRunning) {
        const double next = session.next_time();
        rehearsal_.duration = std::max(rehearsal_.duration + kRehearsedCycle, next < kLatest ? next : 0.0);
      } else {
        break;
      }
    }
    if (progress == Progress::kFailed) {
      add(Severity::kError, Code::kNotPossibleNow, session.error().text, "",
          {session.error().line, session.error().column});
    } else if (progress == Progress::kRunning) {
      add(Severity::kNote, Code::kNote,
          "on nominal values the program does not come to an end: its rehearsal ends here",
          "Set \"nominal_inputs\" in the map if it waits for an input", session.at());
    }
  }

 private:
  static constexpr double kLatest = 1e9;  // s

  void add(Severity severity, Code code, std::string message, std::string hint, const TextLocation& at) {
    diagnostics_.add({.severity = severity,
                      .code = code,
                      .file = file_,
                      .pointer = {},
                      .message = std::move(message),
                      .hint = std::move(hint),
                      .line = at.line,
                      .column = at.column});
  }

  void play_next() {
    const ScriptGroup group(queue_, file_);
    if (++rounds_[group.items.front().name] > kMostPlayedLines) {
      ended_ = true;
      return;
    }
    play(group);
  }

  void play(const ScriptGroup& group) {
    Diagnostics own;
    const auto step = group.to_step(own);
    unread_ = {};
    const program::NodeParser::Inner inner(parser_, false);
    const auto node = parser_.node(step, node_.pointer);
    own.append(unread_);
    program::Scope scope;
    if (!own.has_errors()) node->rehearse(rehearsal_, scope, own);
    group.locate(own);
    diagnostics_.append(own);
  }

  [[nodiscard]] double now() const override { return rehearsal_.duration; }
  [[nodiscard]] double cycle() const override { return kRehearsedCycle; }
  [[nodiscard]] bool settled() override { return queue_.empty(); }
  [[nodiscard]] int unfinished() override {
    return static_cast<int>(std::ranges::count_if(queue_, [](const ScriptItem& one) { return one.moves; }));
  }
  [[nodiscard]] std::string move(urscript::MotionCommand motion) override {
    lasts_ = false;
    return UrscriptHost::move(std::move(motion));
  }
  /// Each one is played once: where it leaves the arm is not known.
  [[nodiscard]] std::string last(const urscript::LastingCommand& command) override {
    lasts_ = true;
    auto step = lasting_step(command, map_);
    const auto name = step.at("name").get<std::string>();
    if (rounds_[name]++ > 0) return {};
    step["seconds"] = kRehearsedCycle;
    play(ScriptGroup(
        {.step = std::make_shared<const nlohmann::ordered_json>(std::move(step)), .name = name, .at = command.at},
        file_));
    forget_goal();
    return {};
  }
  [[nodiscard]] bool lasts() const override { return lasts_; }
  void stop() override {
    queue_.clear();
    lasts_ = false;
  }
  [[nodiscard]] std::optional<double> read(urscript::Signal signal, int number) override {
    if (signal == urscript::Signal::kDigitalIn)
      return map_.inputs.contains(number) ? std::optional(map_.nominal_inputs.contains(number) ? 1.0 : 0.0)
                                          : std::nullopt;
    if (signal == urscript::Signal::kAnalogIn)
      return map_.analog_inputs.contains(number) ? std::optional(0.0) : std::nullopt;
    return written(signal, number);
  }
  void message(const std::string&, const std::string&, const TextLocation&) override {}
  [[nodiscard]] kinematics::JointVector joints(bool) override {
    const auto found = rehearsal_.q.find(map_.arm);
    return found != rehearsal_.q.end() ? found->second : arm().start;
  }
  void run_beside(ScriptItem item) override { play(ScriptGroup(std::move(item), file_)); }
  [[nodiscard]] operations::Rehearsal trial() override {
    operations::Rehearsal trial;
    trial.cell = rehearsal_.cell;
    trial.q = rehearsal_.q;
    trial.modes = rehearsal_.modes;
    return trial;
  }

  const program::Node& node_;
  operations::Rehearsal& rehearsal_;
  Diagnostics& diagnostics_;
  Diagnostics unread_;
  program::NodeParser parser_;
  std::map<std::string, int> rounds_;
  bool ended_ = false, lasts_ = false;
};

}  // namespace

void rehearse_urscript(std::shared_ptr<const urscript::Program> program, const std::string& file,
                       const UrscriptMap& map, const program::Node& node, operations::Rehearsal& rehearsal,
                       Diagnostics& diagnostics) {
  UrscriptRehearsal(file, map, node, rehearsal, diagnostics).play(std::move(program));
}

}  // namespace takt::languages
