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
#include "core/program/tree/strand.h"
#include "languages/krl/lexer.h"
#include "languages/program/krl_host.h"
#include "languages/program/krl_rehearsal.h"

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

/// Steps that run, with the node that they are.
struct RunningGroup {
  KrlGroup group;
  std::unique_ptr<program::Node> node = {};
  std::unique_ptr<program::Scope> scope = {};
  std::unique_ptr<program::NodeRun> run = {};
  std::unique_ptr<program::ControlLine> line = {};  ///< of what runs beside the motions
};

/// The machine on the arm: what it gives becomes nodes of the program, which run one after the other on the line of
/// control of the node. The last motion may be left open, so that the next one goes on with it.
class RunHost final : public KrlHost {
 public:
  RunHost(const KrlNode& node, Execution& execution)
      : KrlHost(node.map, execution.context.cell), node_(node), execution_(execution), machine_(*node.krl, *this) {
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
        failures_.append(machine_.diagnostics());
        cancel();
      }
      again = advance_main() || advance_beside();
      if (again && !execution_.charge_round(mark, node_.pointer, diagnostics)) return Outcome::kFailed;
    }
    if ((failed_ || stopped_) && !cancelled_) cancel();
    if (!settled() || !beside_.empty()) return Outcome::kRunning;
    if (!failures_.empty()) {
      diagnostics.append(failures_);
      return Outcome::kFailed;
    }
    if (stopped_) return Outcome::kStopped;
    if (progress != Progress::kHalted) return progress == Progress::kEnded ? Outcome::kDone : Outcome::kRunning;
    execution_.context.event("krl", "HALT", fmt::format("line {}", line()));
    return Outcome::kStopped;
  }

  void cancel() {
    cancelled_ = true;
    queue_.clear();
    kept_.clear();
    stop_motion();
    for (RunningGroup& one : beside_) {
      const program::OnControlLine line(execution_, *one.line);
      one.run->cancel(execution_);
    }
  }

 private:
  /// @return true if something has ended, or begins
  bool advance_main() {
    if (!main_ && !queue_.empty() && !braking_) {
      RunningGroup next{.group = take_group(queue_)};
      if (!make(next)) {
        failed_ = true;
        return false;
      }
      next.run = next.node->begin(*next.scope);
      main_ = std::make_unique<RunningGroup>(std::move(next));
    }
    if (!main_) return advance_open();
    Diagnostics own;
    const Outcome outcome = execution_.advance_in(node_.name, *main_->run, own);
    if (outcome == Outcome::kRunning) return false;
    end(outcome, own, main_->group);
    open_ = execution_.strand->open_arm().empty() ? KrlGroup{} : main_->group;
    // What was left open refers to its node, and so does what takes it over.
    constexpr std::size_t kMostPast = 4;
    past_.push_back(std::move(main_));
    if (past_.size() > kMostPast) past_.pop_front();
    return true;
  }

  /// Nothing follows the motion that was left open, so far: it may have come to its goal.
  bool advance_open() {
    if (execution_.strand->open_arm().empty()) {
      braking_ = false;
      past_.clear();
      return false;
    }
    Diagnostics own;
    const operations::Progress progress = execution_.strand->advance(execution_, own);
    if (progress == operations::Progress::kRunning) return false;
    end(progress == operations::Progress::kFailed ? Outcome::kFailed : Outcome::kDone, own, open_);
    return true;
  }

  void end(Outcome outcome, Diagnostics& own, const KrlGroup& group) {
    stopped_ = stopped_ || outcome == Outcome::kStopped;
    if (outcome != Outcome::kFailed || braking_ || cancelled_) return;
    failed_ = true;
    if (!group.items.empty()) locate(own, group, *node_.krl);
    failures_.append(own);
  }

  bool advance_beside() {
    bool ended = false;
    for (std::size_t i = 0; i < beside_.size();) {
      RunningGroup& one = beside_[i];
      Diagnostics own;
      Outcome outcome = Outcome::kRunning;
      {
        const program::OnControlLine line(execution_, *one.line);
        outcome = execution_.advance_in(node_.name, *one.run, own);
      }
      if (outcome == Outcome::kRunning) {
        ++i;
        continue;
      }
      end(outcome, own, one.group);
      beside_.erase(beside_.begin() + static_cast<std::ptrdiff_t>(i));
      ended = true;
    }
    return ended;
  }

  /// @return false with failures
  bool make(RunningGroup& group) {
    Diagnostics own;
    const auto step = to_step(group.group, map_, cell_, *node_.krl, own);
    if (!own.has_errors()) {
      program::NodeParser parser(cell_, nullptr, own);
      const program::NodeParser::Inner inner(parser, false);
      group.node = parser.node(step, node_.pointer);
    }
    group.scope = std::make_unique<program::Scope>();
    if (!own.has_errors()) return true;
    locate(own, group.group, *node_.krl);
    failures_.append(own);
    return false;
  }

  /// Brakes on the path what moves.
  void stop_motion() {
    if (main_) main_->run->cancel(execution_);
    execution_.strand->cancel(execution_);
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
  [[nodiscard]] bool settled() override { return queue_.empty() && !main_ && execution_.strand->open_arm().empty(); }
  [[nodiscard]] int unfinished() override {
    std::size_t count = 0;
    for (const KrlItem& one : queue_) count += one.motion ? 1 : 0;
    if (main_ && main_->group.moves()) count += main_->group.items.size() - first_left(main_->group, execution_);
    if (!execution_.strand->open_arm().empty()) ++count;
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
    if (main_ && main_->group.moves()) {
      auto& items = main_->group.items;
      for (std::size_t i = first_left(main_->group, execution_); i < items.size(); ++i) kept_.push_back(items[i]);
    } else if (!execution_.strand->open_arm().empty() && !open_.items.empty()) {
      kept_.push_back(open_.items.back());
    }
    for (KrlItem& one : queue_) kept_.push_back(std::move(one));
    queue_.clear();
    braking_ = true;
    stop_motion();
  }
  void go_on() override {
    braking_ = false;
    if (!kept_.empty() && kept_.front().motion && kept_.front().motion->points.size() > 1) {
      krl::error_at(failures_, node_.krl->modules[static_cast<std::size_t>(kept_.front().module)].file,
                    kept_.front().at, Code::kUnsupported,
                    "a circle or spline that an interrupt has stopped cannot go on",
                    "End the interrupt program with RESUME");
      failed_ = true;
      return;
    }
    for (KrlItem& one : queue_) kept_.push_back(std::move(one));
    queue_ = std::exchange(kept_, {});
  }
  void forget() override {
    queue_.clear();
    kept_.clear();
    braking_ = true;
    stop_motion();
  }
  /// Before anything was sent the arm is where it begins.
  [[nodiscard]] kinematics::JointVector position() const override {
    const kinematics::JointVector& sent = arm().set_point();
    return sent.size() > 0 ? sent : arm().start;
  }

  void run_beside(KrlItem item) override {
    RunningGroup made;
    made.group.items.push_back(std::move(item));
    if (!make(made)) {
      failed_ = true;
      return;
    }
    made.line = std::make_unique<program::ControlLine>();
    made.run = std::make_unique<program::SettledRun>(made.node->begin(*made.scope));
    beside_.push_back(std::move(made));
  }

  const KrlNode& node_;
  Execution& execution_;
  krl::Machine machine_;
  std::unique_ptr<RunningGroup> main_;
  KrlGroup open_;  ///< whose last motion was left open
  std::deque<std::unique_ptr<RunningGroup>> past_;
  std::vector<RunningGroup> beside_;
  std::deque<KrlItem> kept_;  ///< while an interrupt program runs
  Diagnostics failures_;
  bool cancelled_ = false, failed_ = false, stopped_ = false;
  bool braking_ = false;  ///< how what moves comes to an end does not matter
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

/// The form of the steps that a map has.
void check_steps(const KrlMap& map, const std::string& pointer, program::NodeParser& parser) {
  const auto check = [&](const std::string& text, const std::string& at) {
    if (text.empty()) return;
    const auto json = parse_json(text);
    if (!json) return;
    const program::NodeParser::Inner inner(parser, false);
    if (!json->is_array()) return (void)parser.node(*json, at);
    for (std::size_t i = 0; i < json->size(); ++i) (void)parser.node((*json)[i], at + pointer_segment(i));
  };
  for (const auto& [number, output] : map.outputs) {
    check(output.on, fmt::format("{}/outputs/{}/on", pointer, number));
    check(output.off, fmt::format("{}/outputs/{}/off", pointer, number));
  }
  for (const auto& [name, steps] : map.calls) check(steps, pointer + "/calls" + pointer_segment(name));
}

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
