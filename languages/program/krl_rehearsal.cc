#include "languages/program/krl_rehearsal.h"

#include <map>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "languages/program/krl_host.h"

namespace takt::languages {
namespace {

/// A line of a loop is played so often.
constexpr int kMostPlayed = 100;
/// Cycles in which nothing happens, as of a loop that asks for an input.
constexpr int kMostIdle = 2'000;
constexpr double kIdle_s = 0.01;

class RehearsalHost final : public KrlHost {
 public:
  RehearsalHost(const krl::Program& program, const KrlMap& map, const program::Node& node,
                operations::Rehearsal& rehearsal, Diagnostics& diagnostics)
      : KrlHost(map, rehearsal.cell),
        program_(program),
        node_(node),
        rehearsal_(rehearsal),
        diagnostics_(diagnostics),
        parser_(rehearsal.cell, nullptr, unread_) {}

  void play() {
    krl::Machine machine(program_, *this);
    prepare(machine);
    using Progress = krl::Machine::Progress;
    Progress progress = Progress::kRunning;
    for (int idle = 0; idle < kMostIdle && !ended_; ++idle) {
      if (progress != Progress::kFailed) progress = machine.advance();
      if (!queue_.empty()) {
        play_next();
        idle = 0;
      } else if (progress == Progress::kRunning) {
        rehearsal_.duration += kIdle_s;
      } else {
        break;
      }
    }
    if (progress == Progress::kFailed) diagnostics_.append(machine.diagnostics());
    if (progress == Progress::kRunning) note_end(machine);
  }

 private:
  void note_end(const krl::Machine& machine) {
    Diagnostic note{.severity = Severity::kNote,
                    .code = Code::kNote,
                    .file = program_.modules.front().file,
                    .pointer = {},
                    .message = "on nominal values the program does not come to an end: its rehearsal ends here",
                    .hint = "Set \"nominal_inputs\" in the map if it waits for an input",
                    .line = machine.at().line,
                    .column = machine.at().column};
    diagnostics_.add(std::move(note));
  }

  void play_next() {
    const KrlGroup group = take_group(queue_);
    if (++rounds_[group.items.front().name] > kMostPlayed) {
      ended_ = true;
      return;
    }
    play(group);
  }

  void play(const KrlGroup& group) {
    Diagnostics own;
    const auto step = to_step(group, map_, rehearsal_.cell, program_, own);
    if (!step.is_null()) {
      unread_ = {};
      const program::NodeParser::Inner inner(parser_, false);
      const auto node = parser_.node(step, node_.pointer);
      own.append(unread_);
      program::Scope scope;
      if (!own.has_errors()) node->rehearse(rehearsal_, scope, own);
    }
    locate(own, group, program_);
    diagnostics_.append(own);
  }

  [[nodiscard]] double now() const override { return rehearsal_.duration; }
  [[nodiscard]] bool settled() override { return queue_.empty(); }
  [[nodiscard]] int unfinished() override {
    int count = 0;
    for (const KrlItem& one : queue_) count += one.motion ? 1 : 0;
    return count;
  }
  [[nodiscard]] std::optional<double> read(krl::Live signal, int number) override {
    switch (signal) {
      case krl::Live::kIn:
        if (!map_.inputs.contains(number)) return std::nullopt;
        return map_.nominal_inputs.contains(number) ? 1.0 : 0.0;
      case krl::Live::kAnalogIn:
        return map_.analog_inputs.contains(number) ? std::optional(0.0) : std::nullopt;
      default:
        break;
    }
    const bool known = signal == krl::Live::kOut ? map_.outputs.contains(number) : map_.analog_outputs.contains(number);
    const auto found = written_.find({signal, number});
    if (!known) return std::nullopt;
    return found == written_.end() ? 0.0 : found->second;
  }
  [[nodiscard]] bool skips_wait(std::optional<double> seconds) override {
    rehearsal_.duration += seconds.value_or(0.0);
    return true;
  }
  void brake() override {}
  void go_on() override {}
  void forget() override { queue_.clear(); }
  [[nodiscard]] kinematics::JointVector position() const override { return rehearsal_.q.at(map_.arm); }
  void run_beside(KrlItem item) override {
    KrlGroup group;
    group.items.push_back(std::move(item));
    play(group);
  }

  const krl::Program& program_;
  const program::Node& node_;
  operations::Rehearsal& rehearsal_;
  Diagnostics& diagnostics_;
  Diagnostics unread_;
  program::NodeParser parser_;
  std::map<std::string, int> rounds_;
  bool ended_ = false;
};

}  // namespace

void rehearse_krl(const krl::Program& krl, const KrlMap& map, const program::Node& node,
                  operations::Rehearsal& rehearsal, Diagnostics& diagnostics) {
  RehearsalHost(krl, map, node, rehearsal, diagnostics).play();
}

}  // namespace takt::languages
