// One of several cases, by conditions.
#include <algorithm>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/node_forms.h"
#include "core/program/tree/question.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

struct Case {
  Question when;
  std::unique_ptr<Node> steps;
};

class BranchNode final : public Node {
 public:
  std::vector<Case> cases;
  std::unique_ptr<Node> otherwise;  ///< never null; empty where the file has none

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;

  /// All cases are played, each from the state before. What follows begins where the case of the nominal values ends;
  /// if they are not known, the first. A contact or an estimate of any case counts as known then.
  void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const override {
    const operations::Rehearsal before = rehearsal;
    const Scope::Saved values = scope.save();
    std::optional<std::size_t> chosen;
    bool open = false;  // a condition before was unknown
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const auto holds = cases[i].when.rehearse(rehearsal, scope, diagnostics);
      open = open || !holds;
      if (!chosen && !open && *holds) chosen = i;
    }
    if (!chosen && !open) chosen = cases.size();
    std::optional<operations::Rehearsal> after;
    Scope::Saved values_after;
    const std::size_t taken = chosen.value_or(0);
    for (std::size_t i = 0; i <= cases.size(); ++i) {
      operations::Rehearsal own = before;
      own.effort = rehearsal.effort;
      scope.restore(values);
      // A case that nominal values do not select may not be possible with them.
      Diagnostics inside;
      way(i).rehearse(own, scope, inside);
      if (chosen && i != taken) inside = as_warnings(inside, "nominal values do not come here");
      diagnostics.append(inside);
      rehearsal.effort = own.effort;
      merge(own, rehearsal);
      if (i != taken) continue;
      after = std::move(own);
      values_after = scope.save();
    }
    merge(rehearsal, *after);
    after->effort = rehearsal.effort;
    rehearsal = std::move(*after);
    scope.restore(values_after);
  }

  [[nodiscard]] std::int64_t count() const override {
    std::int64_t most = otherwise->count();
    for (const Case& one : cases) most = std::max(most, one.steps->count());
    return most;
  }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    for (const Case& one : cases) one.steps->collect_names(names);
    otherwise->collect_names(names);
  }
  [[nodiscard]] bool constant() const override {
    return otherwise->constant() && std::ranges::all_of(cases, [](const Case& one) {
             return one.when.piece().constant() && one.steps->constant();
           });
  }
  [[nodiscard]] std::optional<Json> state_before(std::string_view wanted) const override {
    if (const auto own = Node::state_before(wanted)) return own;
    for (std::size_t i = 0; i <= cases.size(); ++i) {
      auto inside = way(i).state_before(wanted);
      if (inside) return Json{{"way", i}, {"run", std::move(*inside)}};
    }
    return std::nullopt;
  }

  [[nodiscard]] const Node& way(std::size_t i) const { return i < cases.size() ? *cases[i].steps : *otherwise; }

 private:
  static void merge(const operations::Rehearsal& from, operations::Rehearsal& into) {
    into.contacts.insert(from.contacts.begin(), from.contacts.end());
    into.estimates.insert(from.estimates.begin(), from.estimates.end());
    operations::keep_agreed_modes(from, into);
    for (const auto& [arm, touched] : from.touched) into.touched[arm] = into.touched[arm] || touched;
  }
};

class BranchRun final : public NodeRun {
 public:
  BranchRun(const BranchNode& node, Scope& scope) : node_(node), scope_(scope) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    while (!run_) {
      if (cancelled_) return Outcome::kDone;
      if (case_ >= node_.cases.size()) {
        take(execution, node_.cases.size());
        break;
      }
      if (!question_) question_.emplace(node_.cases[case_].when, scope_);
      const operations::Progress progress = question_->advance(execution, diagnostics);
      if (progress == operations::Progress::kRunning) return Outcome::kRunning;
      const bool holds = progress == operations::Progress::kDone && question_->answer();
      question_.reset();
      if (cancelled_) return Outcome::kDone;
      if (progress == operations::Progress::kFailed) return Outcome::kFailed;
      if (holds) {
        take(execution, case_);
      } else {
        ++case_;
      }
    }
    return execution.advance_in(node_.name, *run_, diagnostics);
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    if (question_) question_->cancel();
    if (run_) run_->cancel(execution);
  }

  [[nodiscard]] Json state() const override {
    if (!run_) return {{"case", case_}};
    return {{"way", way_}, {"run", run_->state()}};
  }
  void restore(const Json& state, Execution& execution, Diagnostics& diagnostics) override {
    if (!state.contains("way")) return;
    way_ = state.at("way").get<std::size_t>();
    if (way_ > node_.cases.size()) throw std::out_of_range("there is no such case");
    run_ = node_.way(way_).begin(scope_);
    run_->restore(state.at("run"), execution, diagnostics);
  }

 private:
  void take(Execution& execution, std::size_t way) {
    way_ = way;
    run_ = node_.way(way).begin(scope_);
    const bool otherwise = way == node_.cases.size();
    execution.context.event("program", "branch",
                            fmt::format("{}: {}", node_.name, otherwise ? "else" : fmt::format("case {}", way)));
  }

  const BranchNode& node_;
  Scope& scope_;
  std::size_t case_ = 0, way_ = 0;
  std::optional<QuestionRun> question_;
  std::unique_ptr<NodeRun> run_;
  bool cancelled_ = false;
};

std::unique_ptr<NodeRun> BranchNode::begin(Scope& scope) const { return std::make_unique<BranchRun>(*this, scope); }

Case parse_case(const Json& json, const std::string& pointer, NodeParser& parser) {
  ObjectReader reader(json, pointer, parser.diagnostics());
  Case one;
  if (const Json* when = reader.child("when")) {
    one.when = Question::parse(*when, reader.at("when"), parser);
  } else if (json.is_object()) {
    parser.diagnostics().error(Code::kMissing, pointer, "key 'when' is missing", "Give \"$...\", or a condition {...}");
  }
  const NodeParser::Inner inner(parser);
  one.steps = parser.steps(reader, "steps");
  reader.finish();
  return one;
}

}  // namespace

std::unique_ptr<Node> parse_branch(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<BranchNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "branch");
  FormReader(branch_form(), reader).elements("cases", [&](const Json& one, const std::string& place) {
    node->cases.push_back(parse_case(one, place, parser));
  });
  node->otherwise = parser.steps(reader, "else", false);
  reader.finish();
  return node;
}

}  // namespace takt::program
