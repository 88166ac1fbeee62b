// Branches side by side.
#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/node_forms.h"
#include "core/program/tree/outcome_json.h"
#include "core/program/tree/strand.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

class ParallelNode final : public Node {
 public:
  NodeList branches;
  bool first_ends = false;  ///< the branch that is done first ends the others

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;

  /// One after the other, from the same beginning. What two of them drive is a conflict.
  void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const override {
    operations::settle_rehearsal(rehearsal, diagnostics);
    operations::BranchesTogether together(rehearsal, pointer);
    const Scope::Saved values = scope.save();
    for (;;) {
      Diagnostics said;
      play(rehearsal, scope, together, said);
      // A `move` goes around what the others do, which is known only now.
      if (!together.play_again(said)) {
        diagnostics.append(said);
        break;
      }
      scope.restore(values);
    }
    together.finish(diagnostics);
  }

  /// @param diagnostics  gets what is wrong with each branch
  void play(operations::Rehearsal& rehearsal, Scope& scope, operations::BranchesTogether& together,
            Diagnostics& diagnostics) const {
    const double begin = rehearsal.duration;
    std::vector<double> durations;
    std::map<std::string, std::size_t, std::less<>> owner;
    for (std::size_t i = 0; i < branches.size(); ++i) {
      std::set<std::string, std::less<>> claimed;
      auto* const outer = std::exchange(rehearsal.claimed, &claimed);
      rehearsal.duration = begin;
      together.begin_branch();
      branches[i]->rehearse(rehearsal, scope, diagnostics);
      together.end_branch();
      operations::settle_rehearsal(rehearsal, diagnostics);
      rehearsal.claimed = outer;
      durations.push_back(rehearsal.duration);
      for (const std::string& device : claimed) {
        const auto [found, fresh] = owner.emplace(device, i);
        if (!fresh) conflict(device, found->second, i, diagnostics);
        if (outer) outer->insert(device);
      }
    }
    rehearsal.duration = first_ends ? std::ranges::min(durations) : std::ranges::max(durations);
  }

  [[nodiscard]] std::int64_t count() const override {
    std::int64_t sum = 0;
    for (const auto& branch : branches) sum = std::min(kMostSteps, sum + branch->count());
    return sum;
  }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    for (const auto& branch : branches) branch->collect_names(names);
  }
  [[nodiscard]] bool constant() const override {
    return std::ranges::all_of(branches, [](const auto& branch) { return branch->constant(); });
  }

 private:
  void conflict(const std::string& device, std::size_t a, std::size_t b, Diagnostics& diagnostics) const {
    diagnostics.error(Code::kResourceConflict, fmt::format("{}/branches/{}", pointer, b),
                      fmt::format("'{}' is driven here and in branch {} at the same time", device, a),
                      "Drive the device in one branch only, or put the branches one after the other");
  }
};

/// What runs meanwhile belongs to a parallel; the outermost counts.
class InParallel {
 public:
  InParallel(activity::Context& context, const std::string& pointer)
      : context_(context), outermost_(context.meanwhile.parallel.empty()) {
    if (!outermost_) return;
    context_.meanwhile.parallel = pointer;
    context_.scheduler->set_alone(false);
  }
  ~InParallel() {
    if (!outermost_) return;
    context_.meanwhile.parallel.clear();
    context_.scheduler->set_alone(true);
  }
  InParallel(const InParallel&) = delete;
  InParallel& operator=(const InParallel&) = delete;

 private:
  activity::Context& context_;
  bool outermost_;
};

class ParallelRun final : public NodeRun {
 public:
  ParallelRun(const ParallelNode& node, Scope& scope) : node_(node) {
    for (const auto& branch : node.branches) {
      branches_.push_back({std::make_unique<SettledRun>(branch->begin(scope)), Outcome::kRunning, {}});
    }
  }

  /// Each branch once, in their order. One that fails or stops the program ends the others, as the first that is done
  /// does if it is to.
  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (!begun_) {
      const Outcome ready = settle(execution, diagnostics);
      if (ready != Outcome::kDone) return ready;
      begun_ = true;
    }
    diagnostics.append(std::exchange(to_tell_, {}));
    ask_for_end(execution);  // a state that was put back may say so
    const InParallel inside(execution.context, node_.pointer);
    for (Branch& branch : branches_) {
      if (branch.outcome != Outcome::kRunning) continue;
      const OnControlLine line(execution, branch.strand);
      Diagnostics own;
      branch.outcome = execution.advance_in(node_.name, *branch.run, own);
      diagnostics.append(own);
      if (branch.outcome == Outcome::kRunning) continue;
      branch.run.reset();
      note_end(branch.outcome);
      if (branch.outcome == Outcome::kFailed) failures_.append(own);
    }
    ask_for_end(execution);
    const bool running =
        std::ranges::any_of(branches_, [](const Branch& branch) { return branch.outcome == Outcome::kRunning; });
    return running ? Outcome::kRunning : result_;
  }

  void cancel(Execution& execution) override { cancel_all(execution); }

  [[nodiscard]] Json state() const override {
    Json list = Json::array(), open = Json::array();
    for (const Branch& branch : branches_) {
      list.push_back(branch.run ? branch.run->state() : Json());
      open.push_back(branch.strand.state());
    }
    Json state{{"branches", std::move(list)}, {"open", std::move(open)}, {"ends", ends_}, {"begun", begun_}};
    state["result"] = outcome_to_json(result_);
    state["failures"] = diagnostics_to_json(failures_);
    return state;
  }
  void restore(const Json& state, Execution& execution, Diagnostics& diagnostics) override {
    if (!state.contains("branches")) return;
    for (std::size_t i = 0; i < branches_.size(); ++i) {
      const Json& branch = state.at("branches").at(i);
      if (branch.is_null()) {
        branches_[i] = {nullptr, Outcome::kDone, {}};
        continue;
      }
      const OnControlLine line(execution, branches_[i].strand);
      branches_[i].run->restore(branch, execution, diagnostics);
      branches_[i].strand.restore(state.at("open").at(i), execution, diagnostics);
    }
    begun_ = state.at("begun").get<bool>();
    ends_ = state.at("ends").get<bool>();
    result_ = outcome_from_json(state.at("result"));
    failures_ = to_tell_ = diagnostics_from_json(state.at("failures"));
  }

 private:
  struct Branch {
    std::unique_ptr<NodeRun> run;
    Outcome outcome = Outcome::kRunning;
    ControlLine strand;
  };

  void note_end(Outcome outcome) {
    if (outcome == Outcome::kFailed || (outcome == Outcome::kStopped && result_ == Outcome::kDone)) result_ = outcome;
    ends_ = ends_ || outcome != Outcome::kDone || node_.first_ends;
  }
  void ask_for_end(Execution& execution) {
    if (ends_ && !std::exchange(asked_, true)) cancel_all(execution);
  }
  void cancel_all(Execution& execution) {
    for (Branch& branch : branches_) {
      const OnControlLine line(execution, branch.strand);
      if (branch.run) branch.run->cancel(execution);
    }
  }

  const ParallelNode& node_;
  std::vector<Branch> branches_;
  Outcome result_ = Outcome::kDone;  ///< of those that are over
  Diagnostics failures_;             ///< of those that have failed, as part of the state
  Diagnostics to_tell_;              ///< what a state that was put back has of them
  bool begun_ = false, ends_ = false, asked_ = false;
};

std::unique_ptr<NodeRun> ParallelNode::begin(Scope& scope) const { return std::make_unique<ParallelRun>(*this, scope); }

}  // namespace

std::unique_ptr<Node> parse_parallel(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<ParallelNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "parallel");
  FormReader from(parallel_form(), reader);
  node->first_ends = from.choice("end") == "first";
  auto frames = parser.take_frames();
  from.elements("branches", [&](const Json& step, const std::string& branch) {
    node->branches.push_back(parser.node(step, branch));
    for (const std::string& frame : parser.take_frames()) {
      if (frames.insert(frame).second) continue;
      parser.diagnostics().error(Code::kDuplicate, branch, fmt::format("two branches have a frame '{}'", frame),
                                 "Give each a name of its own");
    }
  });
  reader.finish();
  return node;
}

}  // namespace takt::program
