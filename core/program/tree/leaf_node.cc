// Leaves of a program: steps. One whose keys hold expressions is made anew each time that it begins.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/expression/moving_frames.h"
#include "core/expression/tool_settings.h"
#include "core/operations/grasp/held_part.h"
#include "core/program/tree/node.h"
#include "core/program/tree/strand.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

/// A step as the file has it.
struct Part {
  std::string name, pointer;
  const operations::Operation* operation = nullptr;
  ValueTemplate piece;
  ValueTemplate::UnitOf unit_of;
  bool blends = false;  ///< into the step after it
};

/// Steps that run as one, ready to run.
struct Instance {
  std::unique_ptr<operations::Step> made;  ///< null if the node owns the step
  const operations::Step* step = nullptr;
  std::string name, pointer;
  std::vector<std::string> absorbed;
  Json steps = Json::array();  ///< with what their expressions are worth; only of one that others may go on with
};

class LeafNode final : public Node {
 public:
  std::vector<Part> parts;
  std::unique_ptr<operations::Step> step;  ///< null if a part holds an expression
  std::vector<std::string> absorbed;

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;
  void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const override;
  [[nodiscard]] std::int64_t count() const override { return static_cast<std::int64_t>(parts.size()); }
  void collect_names(std::vector<std::string>& names) const override {
    for (const Part& part : parts) names.push_back(part.name);
  }
  [[nodiscard]] bool constant() const override { return step != nullptr; }
  /// It has to wait for the end of whatever was left open before.
  [[nodiscard]] bool needs_settled_state(const expression::Cell& cell) const {
    return !parts.front().operation->is_motion ||
           std::ranges::any_of(parts, [&](const Part& part) { return part.piece.changes(cell); });
  }

  /// The steps with what their expressions are worth now. `unknown` gets expressions that are not known.
  [[nodiscard]] std::vector<Instance> instances(const EvalContext& eval_context, expression::Cell& cell,
                                                Diagnostics& diagnostics, std::vector<std::string>& unknown) const {
    std::vector<Instance> result;
    if (step) result.push_back({nullptr, step.get(), name, pointer, absorbed});
    for (const Part& part : parts) {
      if (step && !part.operation->is_motion) break;  // nothing is to be put in, and nothing goes on with it
      const auto resolved = part.piece.resolve(eval_context, cell, part.unit_of, diagnostics);
      unknown.insert(unknown.end(), resolved.unknown.begin(), resolved.unknown.end());
      if (diagnostics.has_errors() || !unknown.empty()) return {};
      if (!step && !add(part, *resolved.json, cell, result, diagnostics)) return {};
      result.back().steps.push_back(*resolved.json);
    }
    return result;
  }

 private:
  /// Makes a part that has no expressions any more; the one before may take it into itself.
  static bool add(const Part& part, const Json& json, expression::Cell& cell, std::vector<Instance>& instances,
                  Diagnostics& diagnostics) {
    auto made = part.operation->read_step({json, part.pointer, cell, diagnostics});
    if (diagnostics.has_errors()) return false;
    if (!instances.empty() && instances.back().made->absorb(*made)) {
      instances.back().absorbed.push_back(part.name);
      return true;
    }
    const operations::Step* const raw = made.get();
    instances.push_back({std::move(made), raw, part.name, part.pointer, {}});
    return true;
  }
};

class LeafRun final : public NodeRun {
 public:
  LeafRun(const LeafNode& node, Scope& scope) : node_(node), scope_(scope) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (!begun_) {
      if (cancelled_) return Outcome::kDone;
      const bool looks = node_.needs_settled_state(execution.context.cell);
      if (const Outcome ready = looks ? settle(execution, diagnostics) : Outcome::kDone; ready != Outcome::kDone)
        return ready;
      if (!execution.may_begin(node_)) return Outcome::kRunning;
      if (!execution.charge(node_.pointer, diagnostics)) return Outcome::kFailed;
      if (!begin(execution, diagnostics)) return Outcome::kFailed;
    }
    while (index_ < instances_.size()) {
      const Outcome outcome = advance_step(execution, diagnostics);
      if (outcome != Outcome::kDone) return outcome;
    }
    return Outcome::kDone;
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    if (run_) run_->cancel(execution.context);
  }

  [[nodiscard]] Json state() const override { return {{"begun", begun_}, {"done", index_}}; }
  /// Steps that were over, or left open, are not begun again.
  void restore(const Json& state, Execution&, Diagnostics&) override { index_ = state.value("done", std::size_t{0}); }

 private:
  bool begin(Execution& execution, Diagnostics& diagnostics) {
    begun_ = true;
    Diagnostics own;
    std::vector<std::string> unknown;
    instances_ = node_.instances(execution.eval_context(scope_), execution.context.cell, own, unknown);
    for (const std::string& text : unknown) {
      own.error(Code::kNotKnownYet, node_.pointer, fmt::format("'{}' is not known yet when this step begins", text),
                "Give it a value before");
    }
    if (own.has_errors()) diagnostics.append(own);  // the rehearsal has told the warnings
    return !own.has_errors();
  }

  Outcome advance_step(Execution& execution, Diagnostics& diagnostics) {
    Instance& instance = instances_[index_];
    if (!run_) {
      if (cancelled_) return finish();
      const operations::Step& step = *instance.step;
      expression::Cell& cell = execution.context.cell;
      const bool other_tool = operations::changes_tool(cell, step.arm_tools());
      const bool goes_on = step.moved_arm() == execution.strand->open_arm() && !other_tool &&
                           step.can_blend_from(execution.context.cell);
      if (const Outcome ready = goes_on ? Outcome::kDone : settle(execution, diagnostics); ready != Outcome::kDone)
        return ready;
      if (!goes_on && is_waiting_for_tool(step, cell)) return Outcome::kRunning;
      // What it would go on with may have failed, or ended, meanwhile.
      if (execution.strand->advance(execution, diagnostics) == operations::Progress::kFailed) return give_up();
      if (!goes_on && !take_up_tools(instance, cell, diagnostics)) return give_up();
      run_ = instance.step->begin();
      part_ = 0;
      entered_ = execution.strand->open_arm().empty();
      if (entered_) enter(execution, instance.name);
    }
    Diagnostics own;
    const operations::Progress progress = advance_run(execution, instance, own);
    if (!entered_ && !enter_after_open(execution, instance, diagnostics)) return give_up();
    follow_part(execution, instance);
    if (progress == operations::Progress::kRunning)
      return cancelled_ ? Outcome::kRunning : leave_open(execution, instance);
    run_.reset();
    ++index_;
    if (!entered_) enter(execution, instance.name);  // it fails before its turn, or was cancelled
    execution.steps_done += 1 + static_cast<std::int64_t>(instance.absorbed.size());
    execution.leave(current_, progress == operations::Progress::kDone ? "end" : "failed", messages_of(own));
    if (progress == operations::Progress::kDone) return Outcome::kDone;
    diagnostics.append(own, instance.pointer);
    return Outcome::kFailed;
  }

  operations::Progress advance_run(Execution& execution, const Instance& instance, Diagnostics& own) {
    const Execution::Inside inside(execution, entered_ ? current_ : instance.name);
    return run_->advance(execution.context, own);
  }

  /// Tool and payload of an arm are told between nets.
  static bool is_waiting_for_tool(const operations::Step& step, const expression::Cell& cell) {
    const operations::ArmTools tools = step.arm_tools();
    const auto is_held = [&](const operations::ArmTool& one) {
      const auto arm = cell.arms.find(one.arm);
      return arm != cell.arms.end() && arm->second.device != nullptr && arm->second.device->held();
    };
    return operations::changes_tool(cell, tools) && std::ranges::any_of(tools, is_held);
  }

  static bool take_up_tools(const Instance& instance, expression::Cell& cell, Diagnostics& diagnostics) {
    const Diagnostics wrong = operations::use_tools(cell, instance.step->arm_tools());
    diagnostics.append(wrong);
    if (!wrong.has_errors()) expression::tell_tool_settings(cell);
    return !wrong.has_errors();
  }

  Outcome finish() {
    index_ = instances_.size();
    return Outcome::kDone;
  }

  /// What the step goes on with has failed, and with it this one.
  Outcome give_up() {
    run_.reset();
    ++index_;
    return Outcome::kFailed;
  }

  /// The step is the one that is being done as soon as what it goes on with is behind it, or over. @return false if
  /// that has failed
  bool enter_after_open(Execution& execution, const Instance& instance, Diagnostics& diagnostics) {
    ControlLine& strand = *execution.strand;
    if (!strand.open_arm().empty()) {
      if (run_->begun()) {
        strand.hand_over(execution);
      } else if (run_->has_taken_over()) {
        return true;
      } else if (const operations::Progress before = strand.advance(execution, diagnostics);
                 before != operations::Progress::kDone) {
        return before == operations::Progress::kRunning;
      } else {
        execution.context.event("program", "no blend", fmt::format("'{}' begins at rest", instance.name));
      }
    }
    entered_ = true;
    enter(execution, instance.name);
    return true;
  }

  /// Where the next step may go on with this one, the program looks for it. @return kRunning: not yet
  Outcome leave_open(Execution& execution, Instance& instance) {
    if (!entered_ || !run_->can_blend_out()) return Outcome::kRunning;
    Json left = instance.step->left_steps();
    auto steps = std::make_shared<Json>(left.is_null() ? std::move(instance.steps) : std::move(left));
    auto frames = std::make_shared<Json>(keep_frames(*steps, execution.context.cell.frames));
    execution.strand->leave_open({.step = std::move(instance.made),
                                  .run = std::move(run_),
                                  .arm = instance.step->moved_arm(),
                                  .name = current_,
                                  .pointer = instance.pointer,
                                  .parts = 1 + static_cast<std::int64_t>(instance.absorbed.size()),
                                  .steps = std::move(steps),
                                  .frames = std::move(frames)});
    ++index_;
    return Outcome::kDone;
  }

  /// Reports how far a step with absorbed ones is. Forwards only: a path may be run back.
  void follow_part(Execution& execution, const Instance& instance) {
    if (!entered_) return;
    for (const std::size_t part = std::min(run_->part(), instance.absorbed.size()); part_ < part; ++part_) {
      execution.leave(current_, "end");
      enter(execution, instance.absorbed[part_]);
    }
  }

  void enter(Execution& execution, const std::string& name) {
    current_ = name;
    execution.enter(name);
  }

  const LeafNode& node_;
  Scope& scope_;
  bool begun_ = false, cancelled_ = false, entered_ = false;
  std::vector<Instance> instances_;
  std::size_t index_ = 0;
  std::unique_ptr<operations::StepRun> run_;
  std::size_t part_ = 0;
  std::string current_;
};

std::unique_ptr<NodeRun> LeafNode::begin(Scope& scope) const { return std::make_unique<LeafRun>(*this, scope); }

namespace {

/// A collision is found on the way to an end that is known all the same.
bool fails_before_its_end(const Diagnostics& diagnostics) {
  return std::ranges::any_of(diagnostics.list(), [](const Diagnostic& one) {
    return one.severity == Severity::kError && one.code != Code::kCollision;
  });
}

}  // namespace

void LeafNode::rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const {
  if (!spend_rehearsal(rehearsal, *this, diagnostics)) return;
  const auto planned = [&](const std::string& arm) { return rehearsal.q[arm]; };
  expression::update_flange_frames(rehearsal.cell, planned);
  Diagnostics own;
  std::vector<std::string> unknown;
  const auto made = instances(sight_of(rehearsal, scope), rehearsal.cell, own, unknown);
  diagnostics.append(own);
  if (own.has_errors()) return;
  if (!unknown.empty()) {
    diagnostics.note(pointer, fmt::format("not checked before the run: '{}' is not known then", unknown.front()),
                     "\"nominal\" where the variable is declared");
    return;
  }
  for (const Instance& instance : made) {
    const bool is_motion = !instance.step->moved_arm().empty();
    const operations::ArmTools tools = instance.step->arm_tools();
    const bool goes_on = is_motion && !operations::changes_tool(rehearsal.cell, tools);
    if (!goes_on) operations::settle_rehearsal(rehearsal, diagnostics);
    const Diagnostics wrong = operations::use_tools(rehearsal.cell, tools);
    diagnostics.append(wrong);
    if (wrong.has_errors()) continue;
    expression::expect_tool_settings(rehearsal.cell);
    rehearsal.step = instance.name;
    const auto before = rehearsal.q;
    Diagnostics found;
    instance.step->rehearse(rehearsal, instance.pointer, found);
    if (fails_before_its_end(found))
      for (const operations::ArmTool& used : tools) rehearsal.lost.insert(used.arm);
    diagnostics.append(found);
    if (!is_motion) operations::invalidate_timing(rehearsal);
    expression::update_flange_frames(rehearsal.cell, planned);
    operations::check_told_masses(before, rehearsal, diagnostics);
  }
}

/// The operations that have this key.
std::vector<std::string> operations_with(std::string_view key) {
  std::vector<std::string> names;
  for (const operations::Operation& operation : operations::Operations::global().all()) {
    const auto& parameters = operation.parameters();
    const bool has =
        std::ranges::any_of(parameters, [&](const operations::ParameterInfo& one) { return one.key == key; });
    if (has && operation.read_step != nullptr) names.emplace_back(operation.name);
  }
  return names;
}

/// A key that this operation does not have, but others do, was hardly mistyped.
void explain_unknown_keys(const Part& part, std::size_t first, Diagnostics& diagnostics) {
  for (std::size_t i = first; i < diagnostics.list().size(); ++i) {
    Diagnostic& diagnostic = diagnostics.list()[i];
    const std::string inside = part.pointer + "/";
    if (diagnostic.code != Code::kUnknownKey || !diagnostic.pointer.starts_with(inside)) continue;
    const auto others = operations_with(std::string_view(diagnostic.pointer).substr(inside.size()));
    if (others.empty()) continue;
    diagnostic.hint =
        fmt::format("a key of {}, not of {}; {}", fmt::join(others, ", "), part.operation->name, diagnostic.hint);
  }
}

/// Errors of form of a step with expressions: what depends on their values shows in the rehearsal only.
void check_form(const Part& part, NodeParser& parser) {
  Diagnostics own;
  expression::Cell cell = parser.cell();
  const auto resolved = part.piece.resolve(parser.eval_context(), cell, part.unit_of, own);
  parser.diagnostics().append(own);
  Diagnostics form;
  (void)part.operation->read_step({*resolved.json, part.pointer, cell, form});
  for (const Diagnostic& diagnostic : form.list()) {
    // An unknown or missing key is wrong whatever its value is.
    const bool wrong_key = diagnostic.code == Code::kUnknownKey || diagnostic.code == Code::kMissing;
    if (wrong_key || !part.piece.depends(diagnostic.pointer)) parser.diagnostics().add(diagnostic);
  }
}

}  // namespace

std::unique_ptr<Node> parse_leaf(const operations::Operation& operation, const Json& json, const std::string& pointer,
                                 NodeParser& parser) {
  auto leaf = std::make_unique<LeafNode>();
  leaf->pointer = pointer;
  Part part{.name = {}, .pointer = pointer, .operation = &operation, .piece = {}, .unit_of = {}, .blends = false};
  part.piece = ValueTemplate::parse(json, pointer, parser.diagnostics());
  part.unit_of = [whole = std::make_shared<const Json>(json)](std::string_view at) {
    return operations::unit_in_operation(*whole, at);
  };
  part.blends = json.contains("blend_m") || json.contains("blend_fraction");
  const auto name = json.find("name");
  part.name = leaf->name =
      name != json.end() && name->is_string() ? name->get<std::string>() : std::string(operation.name);
  for (const char* key : {"do", "name"}) {
    if (part.piece.depends_on_key(key)) {
      parser.diagnostics().error(Code::kNotKnownYet, pointer + "/" + key, fmt::format("an expression at '{}'", key),
                                 "Give a text that is fixed");
    }
  }
  const std::size_t known = parser.diagnostics().list().size();
  if (part.piece.constant()) {
    expression::Cell none;  // without expressions nothing is asked
    const auto resolved = part.piece.resolve(parser.eval_context(), none, part.unit_of, parser.diagnostics());
    leaf->step = operation.read_step({*resolved.json, pointer, parser.cell(), parser.diagnostics()});
  } else {
    check_form(part, parser);
  }
  explain_unknown_keys(part, known, parser.diagnostics());
  leaf->parts.push_back(std::move(part));
  return leaf;
}

bool absorb_leaf(Node& node, Node& next) {
  auto* leaf = dynamic_cast<LeafNode*>(&node);
  auto* follower = dynamic_cast<LeafNode*>(&next);
  if (!leaf || !follower) return false;
  if (leaf->step && follower->step) {
    if (!leaf->step->absorb(*follower->step)) return false;
  } else {
    if (!leaf->parts.back().blends || !leaf->parts.back().operation->is_motion ||
        !follower->parts.front().operation->is_motion)
      return false;
    leaf->step.reset();
  }
  leaf->absorbed.push_back(follower->name);
  for (Part& part : follower->parts) leaf->parts.push_back(std::move(part));
  return true;
}

}  // namespace takt::program
