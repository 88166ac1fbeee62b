// Steps one after the other, with variables and frames of their own.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/program/tree/node.h"
#include "core/program/tree/node_forms.h"
#include "core/program/tree/strand.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

class SequenceNode final : public Node {
 public:
  NodeList children;
  std::vector<Declaration> variables;
  std::vector<std::string> frames;  ///< that steps may make in it, and that end with each round
  std::int64_t times = 1;

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;

  /// One round of a sequence that does the same each time shows whatever the form of the steps can show; a second one
  /// starts where the first ended. The others are taken to last as long as the last one that was played. A sequence
  /// with expressions in it is played whole.
  void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const override {
    const std::int64_t outer = rehearsal.most_rounds;
    const std::int64_t rounds = constant() ? std::min(times, outer) : times;
    double last_round = 0.0;
    std::int64_t played = 0;
    for (; played < rounds && spend_rehearsal(rehearsal, *this, diagnostics); ++played) {
      const double begin = rehearsal.duration;
      // Inside a second round one round is enough, or the effort would double with each level.
      if (played > 0) rehearsal.most_rounds = 1;
      const bool good = rehearse_round(rehearsal, scope, diagnostics);
      last_round = rehearsal.duration - begin;
      rehearsal.most_rounds = outer;
      if (!good) return;
    }
    rehearsal.duration += static_cast<double>(times - played) * last_round;
  }

  [[nodiscard]] std::int64_t count() const override {
    std::int64_t sum = 0;
    for (const auto& child : children) sum = std::min(kMostSteps, sum + child->count());
    return saturated(times, sum);
  }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    for (const auto& child : children) child->collect_names(names);
  }
  [[nodiscard]] bool constant() const override { return constant_; }
  void find_out_if_constant() {
    constant_ = variables.empty() && std::ranges::all_of(children, [](const auto& child) { return child->constant(); });
  }

  [[nodiscard]] std::optional<Json> state_before(std::string_view wanted) const override {
    if (const auto own = Node::state_before(wanted)) return own;
    for (std::size_t i = 0; i < children.size(); ++i) {
      auto inside = children[i]->state_before(wanted);
      if (inside) return Json{{"child", i}, {"run", std::move(*inside)}};
    }
    return std::nullopt;
  }

  /// None of its frames may be there when it begins: they are its own.
  [[nodiscard]] Diagnostics check_frames(const expression::Cell& cell) const {
    Diagnostics diagnostics;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!cell.frames.contains(frames[i])) continue;
      diagnostics.error(Code::kConflict, pointer + "/frames" + pointer_segment(i),
                        fmt::format("frame '{}' is there when the sequence begins", frames[i]),
                        "Give it a name of its own");
    }
    return diagnostics;
  }
  void end_frames(expression::Cell& cell) const {
    for (const std::string& frame : frames) cell.frames.remove(frame);
  }

 private:
  bool rehearse_round(operations::Rehearsal& rehearsal, Scope& around, Diagnostics& diagnostics) const {
    Diagnostics own;
    Scope scope(&around);
    declare(variables, sight_of(rehearsal, scope), scope, own);
    own.append(check_frames(rehearsal.cell));
    for (const auto& child : children) child->rehearse(rehearsal, scope, own);
    end_frames(rehearsal.cell);
    const bool good = !own.has_errors();
    diagnostics.append(own);
    return good;
  }

  bool constant_ = false;
};

class SequenceRun final : public NodeRun {
 public:
  SequenceRun(const SequenceNode& node, Scope& around) : node_(node), scope_(&around) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    const Outcome outcome = advance_round(execution, diagnostics);
    if (outcome != Outcome::kRunning) end_frames(execution);
    return outcome;
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    if (run_) run_->cancel(execution);
  }

  [[nodiscard]] Json state() const override {
    Json state{{"round", round_}, {"child", child_}};
    if (declared_) state["variables"] = scope_.to_json();
    if (run_) state["run"] = run_->state();
    return state;
  }

  /// A state that only says which child is next begins the round as any other.
  void restore(const Json& state, Execution& execution, Diagnostics& diagnostics) override {
    round_ = state.value("round", std::int64_t{0});
    child_ = state.value("child", std::size_t{0});
    if (child_ > node_.children.size()) throw std::out_of_range("there is no such step");
    if (!declare_variables(execution, diagnostics)) return;
    has_frames_ = true;
    if (state.contains("variables")) scope_.from_json(state.at("variables"));
    if (!state.contains("run")) return;
    run_ = node_.children.at(child_)->begin(scope_);
    run_->restore(state.at("run"), execution, diagnostics);
  }

 private:
  Outcome advance_round(Execution& execution, Diagnostics& diagnostics) {
    for (;;) {
      if (!run_) {
        const Outcome next = cancelled_ ? Outcome::kDone : find_next(execution, diagnostics);
        if (next != Outcome::kDone || cancelled_ || ended_) return next;
        run_ = node_.children[child_]->begin(scope_);
      }
      const Outcome outcome = execution.advance_in(node_.name, *run_, diagnostics, node_.times > 1 ? round_ + 1 : 0);
      if (outcome == Outcome::kRunning) return outcome;
      run_.reset();
      if (outcome != Outcome::kDone) return outcome;
      ++child_;
    }
  }

  /// Finds the child that is next, or that the sequence has ended. @return kRunning: not yet
  Outcome find_next(Execution& execution, Diagnostics& diagnostics) {
    for (;;) {
      ended_ = round_ >= node_.times || node_.children.empty();
      if (ended_) return Outcome::kDone;
      if (!declared_) {
        const Outcome ready = settle_for(execution, node_.variables, diagnostics);
        if (ready != Outcome::kDone) return ready;
        if (!declare_variables(execution, diagnostics)) return Outcome::kFailed;
        const Diagnostics taken = node_.check_frames(execution.context.cell);
        diagnostics.append(taken);
        if (taken.has_errors()) return Outcome::kFailed;
        has_frames_ = true;
      }
      if (child_ < node_.children.size()) return Outcome::kDone;
      child_ = 0;
      ++round_;
      declared_ = false;
      end_frames(execution);
      if (!execution.charge_round(mark_, node_.pointer, diagnostics)) return Outcome::kFailed;
    }
  }

  /// Frames of another block of the same name stay.
  void end_frames(Execution& execution) {
    if (std::exchange(has_frames_, false)) node_.end_frames(execution.context.cell);
  }

  /// A round begins.
  bool declare_variables(Execution& execution, Diagnostics& diagnostics) {
    declared_ = true;
    mark_ = execution.begun;
    return declare(node_.variables, execution.eval_context(scope_), scope_, diagnostics);
  }

  const SequenceNode& node_;
  Scope scope_;
  std::int64_t round_ = 0;
  std::size_t child_ = 0;
  bool declared_ = false, cancelled_ = false, ended_ = false;
  bool has_frames_ = false;  ///< a round runs, and the frames of the sequence are its own
  std::int64_t mark_ = 0;    ///< steps of the program when the round began
  std::unique_ptr<NodeRun> run_;
};

std::unique_ptr<NodeRun> SequenceNode::begin(Scope& scope) const { return std::make_unique<SequenceRun>(*this, scope); }

}  // namespace

std::unique_ptr<Node> make_sequence(NodeList children, const std::string& pointer) {
  auto node = std::make_unique<SequenceNode>();
  node->pointer = pointer;
  node->children = std::move(children);
  node->find_out_if_constant();
  return node;
}

std::unique_ptr<Node> parse_sequence(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<SequenceNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "sequence");
  node->times = FormReader(sequence_form(), reader).integer("times");
  const NodeParser::Inner inner(parser);
  node->variables = parser.declarations(reader, "variables");
  node->frames = parser.block_frames(reader, "frames");
  node->children = parser.list(reader, "steps");
  parser.leave_frames(node->frames.size());
  reader.finish();
  node->find_out_if_constant();
  // A million rounds of nothing would keep the runner busy without ever meeting a step.
  if (node->count() == 0 && node->constant()) node->times = 0;
  return node;
}

}  // namespace takt::program
