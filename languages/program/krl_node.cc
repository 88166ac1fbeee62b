#include "languages/program/krl_node.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/device/arm.h"
#include "core/program/tree/node_forms.h"
#include "languages/krl/lexer.h"
#include "languages/program/krl_host.h"
#include "languages/program/krl_rehearsal.h"
#include "languages/program/step_line.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;
using program::Execution;
using program::Outcome;

class KrlNode final : public program::Node {
 public:
  std::shared_ptr<const krl::Program> krl;
  KrlMap map;

  [[nodiscard]] std::unique_ptr<program::NodeRun> begin(program::Scope& scope) const override;
  void rehearse(operations::Rehearsal& rehearsal, program::Scope&, Diagnostics& diagnostics) const override {
    if (krl == nullptr || !program::spend_rehearsal(rehearsal, *this, diagnostics)) return;
    operations::settle_rehearsal(rehearsal, diagnostics);
    rehearse_krl(*krl, map, *this, rehearsal, diagnostics);
  }
  /// How often a loop is run is not known.
  [[nodiscard]] std::int64_t count() const override { return kMostSteps; }
  [[nodiscard]] bool constant() const override { return false; }
  /// Its motions as their steps are named.
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    for (std::size_t i = 0; krl != nullptr && i < krl->code.size(); ++i) {
      const krl::Statement* const one = krl->code[i].statement;
      const bool moves = one != nullptr && krl->code[i].code == krl::Instruction::Code::kExecute &&
                         (one->kind == krl::Statement::Kind::kMotion || one->kind == krl::Statement::Kind::kSpline);
      if (moves) names.push_back(step_name(one->at, one->text));
    }
  }
  /// A number is a line of the program; "12: PTP XP1" begins with one.
  [[nodiscard]] std::optional<Json> state_before(std::string_view wanted) const override {
    if (auto own = Node::state_before(wanted)) return own;
    int line = 0;
    const auto [end, wrong] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), line);
    const std::string_view rest = wanted.substr(static_cast<std::size_t>(end - wanted.data()));
    if (wrong != std::errc{} || line < 1 || (!rest.empty() && !rest.starts_with(": "))) return std::nullopt;
    return Json{{"line", line}};
  }
};

/// Motions or another item of a program as a group of the line.
class KrlStepGroup final : public StepGroup {
 public:
  KrlStepGroup(KrlGroup made, const KrlMap& map, const expression::Cell& cell, const krl::Program& program)
      : group(std::move(made)), map_(map), cell_(cell), program_(program) {}

  [[nodiscard]] Json to_step(Diagnostics& diagnostics) const override {
    return languages::to_step(group, map_, cell_, program_, diagnostics);
  }
  void locate(Diagnostics& diagnostics) const override { languages::locate(diagnostics, group, program_); }

  KrlGroup group;

 private:
  const KrlMap& map_;
  const expression::Cell& cell_;
  const krl::Program& program_;
};

/// The machine on the arm: what it gives becomes nodes of the program, which run one after the other on the line of
/// control of the node. The last motion may be left open, so that the next one goes on with it.
class RunHost final : public KrlHost {
 public:
  RunHost(const KrlNode& node, Execution& execution)
      : KrlHost(node.map, execution.context.cell),
        node_(node),
        execution_(execution),
        line_(node, execution),
        machine_(*node.krl, *this) {
    prepare(machine_);
  }

  [[nodiscard]] bool enter(int line) { return machine_.enter(line); }
  [[nodiscard]] int line() const { return machine_.at().line; }

  Outcome advance(Diagnostics& diagnostics) {
    using Progress = krl::Machine::Progress;
    Progress progress = Progress::kRunning;
    for (bool again = true; again;) {
      const std::int64_t mark = execution_.begun;
      progress = cancelled_ ? Progress::kEnded : machine_.advance();
      if (progress == Progress::kFailed && !cancelled_) {
        line_.fail(machine_.diagnostics());
        cancel();
      }
      if (!queue_.empty() && line_.idle() && !line_.begin(group_of(take_group(queue_)))) break;
      again = line_.advance();
      if (again && !execution_.charge_round(mark, node_.pointer, diagnostics)) return Outcome::kFailed;
    }
    if ((line_.failed() || line_.stopped()) && !cancelled_) cancel();
    if (!settled() || line_.beside()) return Outcome::kRunning;
    if (line_.failed()) {
      diagnostics.append(line_.failures());
      return Outcome::kFailed;
    }
    if (line_.stopped()) return Outcome::kStopped;
    if (progress != Progress::kHalted) return progress == Progress::kEnded ? Outcome::kDone : Outcome::kRunning;
    execution_.context.event("krl", "HALT", fmt::format("line {}", line()));
    return Outcome::kStopped;
  }

  void cancel() {
    cancelled_ = true;
    queue_.clear();
    kept_.clear();
    line_.cancel();
  }

 private:
  [[nodiscard]] std::shared_ptr<const StepGroup> group_of(KrlGroup group) const {
    return std::make_shared<KrlStepGroup>(std::move(group), map_, cell_, *node_.krl);
  }
  static const KrlGroup* krl_group(const StepGroup* group) {
    return group == nullptr ? nullptr : &static_cast<const KrlStepGroup*>(group)->group;
  }

  /// The motions of a group that are not over: those from the one on that is being done.
  static std::size_t first_left(const KrlGroup& group, const Execution& execution) {
    for (std::size_t i = 0; i < group.items.size(); ++i)
      if (std::ranges::find(execution.current, group.items[i].name, &program::RunningStep::name) !=
          execution.current.end())
        return i;
    return 0;
  }

  [[nodiscard]] double now() const override { return execution_.context.core.time() * 1e-9; }
  [[nodiscard]] bool settled() override { return queue_.empty() && line_.settled(); }
  [[nodiscard]] int unfinished() override {
    std::size_t count = 0;
    for (const KrlItem& one : queue_) count += one.motion ? 1 : 0;
    const KrlGroup* const main = krl_group(line_.main());
    if (main != nullptr && main->moves()) count += main->items.size() - first_left(*main, execution_);
    if (line_.open() != nullptr) ++count;
    return static_cast<int>(count);
  }
  [[nodiscard]] std::optional<double> read(krl::Live signal, int number) override {
    const auto value_of = [&](const std::map<int, std::string>& names, const auto& devices) -> std::optional<double> {
      const auto name = names.find(number);
      if (name == names.end()) return std::nullopt;
      const auto device = devices.find(name->second);
      if (device == devices.end() || device->second == nullptr) return std::nullopt;
      return device->second->has_sample() ? static_cast<double>(device->second->sample().value) : 0.0;
    };
    if (signal == krl::Live::kIn) return value_of(map_.inputs, cell_.digital_inputs);
    if (signal == krl::Live::kAnalogIn) return value_of(map_.analog_inputs, cell_.analog_inputs);
    const bool known = signal == krl::Live::kOut ? map_.outputs.contains(number) : map_.analog_outputs.contains(number);
    if (!known) return std::nullopt;
    const auto found = written_.find({signal, number});
    return found == written_.end() ? 0.0 : found->second;
  }
  [[nodiscard]] bool skips_wait(std::optional<double>) override { return false; }

  void brake() override {
    kept_.clear();
    const KrlGroup *const main = krl_group(line_.main()), *const open = krl_group(line_.open());
    if (main != nullptr && main->moves()) {
      for (std::size_t i = first_left(*main, execution_); i < main->items.size(); ++i) kept_.push_back(main->items[i]);
    } else if (open != nullptr) {
      kept_.push_back(open->items.back());
    }
    for (KrlItem& one : queue_) kept_.push_back(std::move(one));
    queue_.clear();
    line_.stop();
  }
  void go_on() override {
    if (!kept_.empty() && kept_.front().motion && kept_.front().motion->points.size() > 1) {
      Diagnostics wrong;
      krl::error_at(wrong, node_.krl->modules[static_cast<std::size_t>(kept_.front().module)].file, kept_.front().at,
                    Code::kUnsupported, "a circle or spline that an interrupt has stopped cannot go on",
                    "End the interrupt program with RESUME");
      line_.fail(wrong);
      return;
    }
    for (KrlItem& one : queue_) kept_.push_back(std::move(one));
    queue_ = std::exchange(kept_, {});
  }
  void forget() override {
    queue_.clear();
    kept_.clear();
    line_.stop();
  }
  /// Before anything was sent the arm is where it begins.
  [[nodiscard]] kinematics::JointVector position() const override {
    const kinematics::JointVector& sent = arm().set_point();
    return sent.size() > 0 ? sent : arm().start;
  }

  void run_beside(KrlItem item) override {
    KrlGroup group;
    group.items.push_back(std::move(item));
    (void)line_.begin_beside(group_of(std::move(group)));
  }

  const KrlNode& node_;
  Execution& execution_;
  StepLine line_;
  krl::Machine machine_;
  std::deque<KrlItem> kept_;  ///< while an interrupt program runs
  bool cancelled_ = false;
};

class KrlRun final : public program::NodeRun {
 public:
  explicit KrlRun(const KrlNode& node) : node_(node) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (!host_) {
      if (cancelled_) return Outcome::kDone;
      if (const Outcome ready = program::settle(execution, diagnostics); ready != Outcome::kDone) return ready;
      host_ = std::make_unique<RunHost>(node_, execution);
      if (line_ > 0 && !host_->enter(line_)) {
        diagnostics.error(Code::kUnknownName, node_.pointer,
                          fmt::format("the program that runs has no statement from line {} on", line_),
                          "Begin at a line of the program itself, not of one that it calls");
        return Outcome::kFailed;
      }
    }
    const Outcome outcome = host_->advance(diagnostics);
    return outcome == Outcome::kFailed && cancelled_ ? Outcome::kDone : outcome;
  }

  void cancel(Execution&) override {
    cancelled_ = true;
    if (host_) host_->cancel();
  }

  [[nodiscard]] Json state() const override { return {{"begun", host_ != nullptr}}; }
  /// The program begins again, as a step does that was running; or at a line that was asked for.
  void restore(const Json& state, Execution&, Diagnostics& diagnostics) override {
    line_ = state.value("line", 0);
    if (state.value("begun", false))
      diagnostics.warning(Code::kNote, node_.pointer, "the KRL program begins again at its first statement",
                          "Begin at a line of it to have a known place");
  }

 private:
  const KrlNode& node_;
  std::unique_ptr<RunHost> host_;
  bool cancelled_ = false;
  int line_ = 0;
};

std::unique_ptr<program::NodeRun> KrlNode::begin(program::Scope&) const { return std::make_unique<KrlRun>(*this); }

std::vector<krl::ModuleText> read_modules(ObjectReader& reader) {
  std::vector<krl::ModuleText> modules;
  const Json* program = reader.object("program");
  const Json* list = program != nullptr && program->contains("modules") ? &program->at("modules") : nullptr;
  if (program != nullptr && (list == nullptr || !list->is_array()))
    reader.diagnostics().error(Code::kMissing, reader.at("program"), "no modules", "Name a file that ends in .src");
  for (std::size_t i = 0; list != nullptr && list->is_array() && i < list->size(); ++i) {
    ObjectReader module((*list)[i], fmt::format("{}/modules/{}", reader.at("program"), i), reader.diagnostics());
    modules.push_back({module.text("name", ""), module.text("file", ""), module.text("source", ""),
                       module.text("data_file", ""), module.text("data", "")});
    module.finish();
  }
  return modules;
}

const Form& krl_form() {
  static const Form form = program::node_form(
      "krl", "Runs a program in KRL on one arm.",
      {any_of_key("program", {"string", "object"},
                  "File of the program (.src), relative to this file and in its folder or below."),
       text_key("arm", "The arm that it moves.").optional("the only one"),
       object_key("map", krl_map_form(), "What its numbers and names are in the cell (docs/krl.md).").optional()});
  return form;
}

}  // namespace

std::unique_ptr<program::Node> parse_krl(const Json& json, const std::string& pointer, program::NodeParser& parser) {
  auto node = std::make_unique<KrlNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "krl");
  node->map = read_krl_map(reader, parser.cell());
  const std::vector<krl::ModuleText> modules = read_modules(reader);
  reader.finish();
  std::set<std::string, std::less<>> calls;
  for (const auto& [name, steps] : node->map.calls) calls.insert(name);
  if (modules.empty()) return node;
  auto program = krl::compile(modules, calls);
  if (!program) {
    parser.diagnostics().append(program.error());
    return node;
  }
  node->krl = std::move(*program);
  check_signals(node->map, *node->krl, parser.diagnostics());
  check_steps(node->map, pointer + "/map", parser);
  return node;
}

program::NodeKind krl_kind() { return {"krl", krl_form(), parse_krl}; }

}  // namespace takt::languages
