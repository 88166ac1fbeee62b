#include "languages/program/tree_node.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/activity/scheduler.h"
#include "core/base/object_reader.h"
#include "core/expression/contact_reader.h"
#include "core/program/tree/node_forms.h"
#include "core/program/tree/strand.h"
#include "languages/program/beside_others.h"
#include "languages/program/tree_leaves.h"

namespace takt::languages {
namespace {

using program::Execution;
using program::Outcome;
using TreeJson = nlohmann::ordered_json;

class TreeNode final : public program::Node {
 public:
  ProgramTree tree;

  [[nodiscard]] std::unique_ptr<program::NodeRun> begin(program::Scope& scope) const override;
  void rehearse(operations::Rehearsal& rehearsal, program::Scope&, Diagnostics& diagnostics) const override;
  /// How often a leaf begins is not known.
  [[nodiscard]] std::int64_t count() const override { return kMostSteps; }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    for (const auto& [spec, leaf] : tree.leaves)
      if (leaf.program.node) leaf.program.node->collect_names(names);
  }
  [[nodiscard]] bool constant() const override { return false; }
};

/// Whether a condition holds; nothing: it is not known.
std::optional<bool> holds_now(const program::Expression& condition, const program::EvalContext& eval_context) {
  Diagnostics wrong;
  const program::Value value = condition.evaluate(eval_context, wrong);
  return wrong.has_errors() || value.null() ? std::nullopt : std::optional(value.boolean());
}

// -- In a run ---------------------------------------------------------------------------------------------------------

class TreeRun final : public program::NodeRun, public TreeLeaves {
 public:
  explicit TreeRun(const TreeNode& node) : node_(node), session_(*node.tree.file, *this) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    execution_ = &execution;
    const Outcome ready = begun_ < 0 ? program::settle(execution, diagnostics) : Outcome::kDone;
    if (ready != Outcome::kDone) return ready;
    const std::int64_t cycle = execution.context.core.cycle();
    if (begun_ < 0) begun_ = cycle;
    // What ends makes the tree begin something else in the same cycle.
    for (bool again = true; again && !over_ && !cancelled_ && !stopped_;) {
      const std::int64_t mark = execution.begun;
      (void)advance_leaves(execution, diagnostics);
      const std::size_t before = runs_.size();
      const TreeStatus status = session_.tick((cycle - begun_) * execution.context.core.period());
      over_ = status != TreeStatus::kRunning;
      failed_ = status == TreeStatus::kFailure;
      again = !over_ && (advance_leaves(execution, diagnostics) || runs_.size() > before);
      if (again && !execution.charge_round(mark, node_.pointer, diagnostics)) return Outcome::kFailed;
    }
    if (over_ || cancelled_ || stopped_) {
      session_.halt();
      (void)advance_leaves(execution, diagnostics);
    }
    if (!(over_ || cancelled_ || stopped_) || !runs_.empty()) return Outcome::kRunning;
    if (stopped_) return Outcome::kStopped;
    if (!failed_ || cancelled_) return Outcome::kDone;
    diagnostics.append(failures_);
    if (session_.error()) {
      Diagnostics own;
      own.add(*session_.error());
      own.set_file(node_.tree.name);
      diagnostics.append(own);
    }
    diagnostics.error(Code::kConditionNotMet, node_.pointer,
                      fmt::format("the behaviour tree '{}' failed", node_.tree.file->main));
    return Outcome::kFailed;
  }

  void cancel(Execution& execution) override {
    execution_ = &execution;
    cancelled_ = true;
    session_.halt();
  }
  [[nodiscard]] TreeJson state() const override { return {{"begun", begun_ >= 0}, {"running", session_.running()}}; }
  /// The tree begins again, as a step does that was running.
  void restore(const TreeJson& state, Execution&, Diagnostics& diagnostics) override {
    if (state.value("begun", false))
      diagnostics.warning(Code::kNote, node_.pointer, "the tree begins at its root",
                          "Begin the program at a step before or after it to have a known state");
  }

 private:
  /// A leaf that is carried out, or was halted and comes to its end.
  struct Run {
    std::size_t number = 0;
    bool wanted = true, begun = false;
    std::optional<Outcome> outcome = {};
    const ProgramLeaf* leaf = nullptr;
    const TreeLeaf* at = nullptr;
    std::unique_ptr<program::Scope> scope;
    std::unique_ptr<program::NodeRun> run;
    std::unique_ptr<program::ControlLine> line;
  };

  TreeStatus tick(std::size_t number, const TreeLeaf& at, bool fresh) override {
    const ProgramLeaf& leaf = node_.tree.leaves.at(at.spec);
    if (leaf.condition) {
      const program::Scope nothing;
      program::EvalContext eval_context = execution_->eval_context(nothing);
      eval_context.readers = &readers_;
      return holds_now(*leaf.condition, eval_context).value_or(false) ? TreeStatus::kSuccess : TreeStatus::kFailure;
    }
    if (fresh) return begin(number, at, leaf);
    const auto run = std::ranges::find_if(runs_, [&](const Run& one) { return one.wanted && one.number == number; });
    if (run == runs_.end() || !run->outcome) return TreeStatus::kRunning;
    const Run ended = std::move(*run);
    runs_.erase(run);
    if (*ended.outcome != Outcome::kDone) return TreeStatus::kFailure;
    if (leaf.program.result) at.board->set(leaf.result_key, entry_of(ended.scope->find(kChartResult)->value));
    return TreeStatus::kSuccess;
  }

  TreeStatus begin(std::size_t number, const TreeLeaf& at, const ProgramLeaf& leaf) {
    auto scope = std::make_unique<program::Scope>();
    Diagnostics wrong;
    if (!declare_arguments(leaf.program, leaf_arguments(at), execution_->eval_context(*scope), *scope, wrong)) {
      move_to_leaf(wrong, 0, node_.tree, *at.spec);
      failures_.append(wrong);
      return TreeStatus::kFailure;
    }
    auto run = std::make_unique<program::SettledRun>(leaf.program.node->begin(*scope));
    runs_.push_back({.number = number,
                     .leaf = &leaf,
                     .at = &at,
                     .scope = std::move(scope),
                     .run = std::move(run),
                     .line = std::make_unique<program::ControlLine>()});
    return TreeStatus::kRunning;
  }

  void halt(std::size_t number, const TreeLeaf&) override {
    for (Run& one : runs_) {
      if (!one.wanted || one.number != number) continue;
      one.wanted = false;
      const program::OnControlLine line(*execution_, *one.line);
      one.run->cancel(*execution_);
    }
  }

  /// Each that runs once, in the order in which they began. What was halted ends before something else begins.
  /// @return true if one that is wanted has ended
  bool advance_leaves(Execution& execution, Diagnostics& diagnostics) {
    bool ended = false;
    const BesideOthers beside(execution.context, runs_.size() > 1);
    const bool clears = std::ranges::any_of(runs_, [](const Run& one) { return !one.wanted && one.begun; });
    for (std::size_t i = 0; i < runs_.size();) {
      Run& one = runs_[i];
      if (one.outcome || (clears && !one.begun && one.wanted)) {
        ++i;
        continue;
      }
      one.begun = true;
      Diagnostics own;
      Outcome outcome = Outcome::kRunning;
      {
        const program::OnControlLine line(execution, *one.line);
        const Execution::Inside inside(execution, node_.name);
        outcome = execution.advance_in(one.leaf->program.id, *one.run, own);
      }
      move_to_leaf(own, 0, node_.tree, *one.at->spec);
      if (outcome == Outcome::kRunning) {
        ++i;
        continue;
      }
      stopped_ = stopped_ || outcome == Outcome::kStopped;
      if (one.wanted) {
        if (outcome == Outcome::kFailed) failures_ = own;  // the tree may go on: only the last ones count
        one.outcome = outcome;
        ended = true;
        ++i;
        continue;
      }
      if (outcome == Outcome::kFailed) diagnostics.append(own);
      runs_.erase(runs_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    if (over_ || cancelled_ || stopped_) std::erase_if(runs_, [](const Run& one) { return one.outcome.has_value(); });
    return ended;
  }

  const TreeNode& node_;
  Execution* execution_ = nullptr;
  std::vector<Run> runs_;
  expression::ContactReaders readers_;
  Diagnostics failures_;
  std::int64_t begun_ = -1;
  bool over_ = false, failed_ = false, cancelled_ = false, stopped_ = false;
  TreeSession session_;
};

// -- In the rehearsal -------------------------------------------------------------------------------------------------

/// Ticks the tree on nominal values: every leaf succeeds after its nominal time.
class TreeRehearsal final : public TreeLeaves {
 public:
  TreeRehearsal(const TreeNode& node, operations::Rehearsal& rehearsal, Diagnostics& diagnostics)
      : node_(node),
        rehearsal_(rehearsal),
        before_(rehearsal),
        diagnostics_(diagnostics),
        session_(*node.tree.file, *this) {}

  void run() {
    const double begin = rehearsal_.duration;
    TreeStatus status = TreeStatus::kRunning;
    for (int i = 0; i < kMostTicks && begun_ < kMostLeaves && status == TreeStatus::kRunning; ++i) {
      status = session_.tick(now_);
      if (status == TreeStatus::kRunning) now_ = next();
    }
    rehearsal_.duration = std::max(rehearsal_.duration, begin + to_seconds(now_));
    if (session_.error()) {
      Diagnostics own;
      own.add(*session_.error());
      own.set_file(node_.tree.name);
      diagnostics_.append(program::as_warnings(own, "entries have nominal values here"));
    } else if (status == TreeStatus::kRunning) {
      diagnostics_.note(
          node_.pointer,
          fmt::format("on nominal values the tree does not come to an end: {}", fmt::join(session_.running(), " / ")),
          "Expect that what follows is not checked before the run");
    }
    play_rest();
  }

 private:
  static constexpr int kMostTicks = 20'000, kMostLeaves = 200;
  static constexpr Nanoseconds kStep = 10 * kMillisecond;

  [[nodiscard]] Nanoseconds next() const {
    Nanoseconds due = now_ + kStep;
    bool first = true;
    for (const auto& [number, end] : ends_) {
      if (end <= now_) continue;
      due = first ? end : std::min(due, end);
      first = false;
    }
    return due;
  }

  TreeStatus tick(std::size_t number, const TreeLeaf& at, bool fresh) override {
    const ProgramLeaf& leaf = node_.tree.leaves.at(at.spec);
    if (leaf.condition) {
      const program::Scope nothing;
      return holds_now(*leaf.condition, program::sight_of(rehearsal_, nothing)).value_or(true) ? TreeStatus::kSuccess
                                                                                               : TreeStatus::kFailure;
    }
    if (fresh) {
      ++begun_;
      played_.insert(at.spec);
      const double started = rehearsal_.duration;
      play(at, leaf, rehearsal_, diagnostics_);
      ends_[number] = now_ + static_cast<Nanoseconds>(std::llround(1e9 * (rehearsal_.duration - started)));
      rehearsal_.duration = started;
    }
    return ends_.at(number) <= now_ ? TreeStatus::kSuccess : TreeStatus::kRunning;
  }
  void halt(std::size_t number, const TreeLeaf&) override { ends_.erase(number); }

  void play(const TreeLeaf& at, const ProgramLeaf& leaf, operations::Rehearsal& rehearsal, Diagnostics& diagnostics) {
    program::Scope scope;
    Diagnostics own;
    if (declare_arguments(leaf.program, leaf_arguments(at), program::sight_of(rehearsal, scope), scope, own))
      leaf.program.node->rehearse(rehearsal, scope, own);
    operations::settle_rehearsal(rehearsal, own);
    if (leaf.program.result) at.board->set(leaf.result_key, entry_of(scope.find(kChartResult)->value));
    move_to_leaf(own, 0, node_.tree, *at.spec);
    diagnostics.append(own);
  }

  /// Where the arms are when these begin is not known.
  void play_rest() {
    for (const TreeLeaf& at : session_.leaves()) {
      const ProgramLeaf& leaf = node_.tree.leaves.at(at.spec);
      if (leaf.condition || !played_.insert(at.spec).second) continue;
      operations::Rehearsal own = before_;
      own.effort = rehearsal_.effort;
      Diagnostics inside;
      play(at, leaf, own, inside);
      diagnostics_.append(program::as_warnings(inside, "the nominal run of the tree does not come here"));
      rehearsal_.effort = own.effort;
      rehearsal_.contacts.insert(own.contacts.begin(), own.contacts.end());
      rehearsal_.estimates.insert(own.estimates.begin(), own.estimates.end());
    }
  }

  const TreeNode& node_;
  operations::Rehearsal& rehearsal_;
  operations::Rehearsal before_;
  Diagnostics& diagnostics_;
  std::map<std::size_t, Nanoseconds> ends_;
  std::set<const TreeNodeSpec*> played_;
  Nanoseconds now_ = 0;
  int begun_ = 0;
  TreeSession session_;
};

std::unique_ptr<program::NodeRun> TreeNode::begin(program::Scope&) const { return std::make_unique<TreeRun>(*this); }

void TreeNode::rehearse(operations::Rehearsal& rehearsal, program::Scope&, Diagnostics& diagnostics) const {
  if (tree.file == nullptr || !program::spend_rehearsal(rehearsal, *this, diagnostics)) return;
  operations::settle_rehearsal(rehearsal, diagnostics);
  TreeRehearsal(*this, rehearsal, diagnostics).run();
}

const Form& tree_form() {
  static const Form form = program::node_form(
      "tree", "Runs a behaviour tree (BehaviorTree.CPP 4) whose leaves are programs.",
      {any_of_key("tree", {"string", "object"},
                  "File of a behaviour tree, relative to this file and in its folder or below."),
       text_key("main", "Tree to run.").optional("main_tree_to_execute of the file, or its only one")});
  return form;
}

}  // namespace

std::unique_ptr<program::Node> parse_tree(const TreeJson& json, const std::string& pointer,
                                          program::NodeParser& parser) {
  auto node = std::make_unique<TreeNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "tree");
  const std::string main = reader.text("main", "");
  const TreeJson* tree = reader.object("tree");
  reader.finish();
  if (tree == nullptr) return node;
  ObjectReader inside(*tree, reader.at("tree"), parser.diagnostics());
  node->tree.name = inside.text("file", "");
  const std::string xml = inside.text("xml");
  inside.finish();
  if (!inside.has("xml")) return node;
  auto read = read_trees(xml, main);
  if (!read) {
    read.error().set_file(node->tree.name);
    parser.diagnostics().append(read.error());
    return node;
  }
  node->tree.file = *read;
  read_tree_leaves(node->tree, pointer, parser);
  return node;
}

program::NodeKind tree_kind() { return {"tree", tree_form(), parse_tree}; }

}  // namespace takt::languages
