// What is done when something fails: again, something else, and always at the end.
#include <algorithm>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/node_forms.h"
#include "core/program/tree/outcome_json.h"
#include "core/program/tree/strand.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

/// Arms that brake after a failure are waited for, so long at most, s.
constexpr double kRestTime_s = 5.0;

class TryNode final : public Node {
 public:
  std::unique_ptr<Node> body, recover, handler, cleanup;  ///< the last three may be empty, never null
  std::int64_t retry = 0;
  bool handles = false;  ///< there is an "on_error"
  std::string as;        ///< variable with what was wrong, for the handler; may be empty

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;

  /// The body, and each other part from where the body began: it is unknown where it fails.
  void rehearse(operations::Rehearsal& rehearsal, Scope& around, Diagnostics& diagnostics) const override {
    operations::Rehearsal before = rehearsal;
    before.open.reset();
    const Scope::Saved values = around.save();
    body->rehearse(rehearsal, around, diagnostics);
    operations::settle_rehearsal(rehearsal, diagnostics);
    const Scope::Saved values_after = around.save();
    for (const Node* part : {recover.get(), handler.get()}) {
      operations::Rehearsal own = before;
      own.effort = rehearsal.effort;
      operations::keep_agreed_modes(rehearsal, own);
      around.restore(values);
      Scope scope(&around);
      declare_error(scope, "an error");
      Diagnostics inside;
      part->rehearse(own, scope, inside);
      operations::settle_rehearsal(own, inside);
      diagnostics.append(as_warnings(inside, "where a failure leaves the arm is not known"));
      rehearsal.effort = own.effort;
      operations::keep_agreed_modes(own, rehearsal);
      rehearsal.contacts.insert(own.contacts.begin(), own.contacts.end());
      rehearsal.estimates.insert(own.estimates.begin(), own.estimates.end());
    }
    around.restore(values_after);
    cleanup->rehearse(rehearsal, around, diagnostics);
  }

  [[nodiscard]] std::int64_t count() const override { return std::min(kMostSteps, body->count() + cleanup->count()); }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    for (const Node* part : {body.get(), recover.get(), handler.get(), cleanup.get()}) part->collect_names(names);
  }
  [[nodiscard]] bool constant() const override {
    return as.empty() && body->constant() && recover->constant() && handler->constant() && cleanup->constant();
  }
  [[nodiscard]] std::optional<Json> state_before(std::string_view wanted) const override {
    if (const auto own = Node::state_before(wanted)) return own;
    auto inside = body->state_before(wanted);
    return inside ? std::optional(Json{{"phase", 0}, {"run", std::move(*inside)}}) : std::nullopt;
  }

  void declare_error(Scope& scope, const std::string& text) const {
    if (!as.empty()) scope.declare(as, {Type::text(), Value::of(text), {}});
  }
};

class TryRun final : public NodeRun {
 public:
  TryRun(const TryNode& node, Scope& around) : node_(node), scope_(&around) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (!opened_before_) {
      opened_before_ = execution.strand->opened();
      failed_before_ = execution.strand->failed();
    }
    for (;;) {
      if (phase_ == Phase::kRest) {
        if (!at_rest(execution)) return Outcome::kRunning;
        after_rest(execution);
      }
      if (!run_) {
        if (cancelled_ && phase_ != Phase::kCleanup) enter(Phase::kCleanup);
        if (phase_ == Phase::kCleanup && execution.cancelled) return end(diagnostics);
        if (phase_ == Phase::kCleanup) execution.strand->protect(true);
        run_ = std::make_unique<SettledRun>(part().begin(scope_));
      }
      Diagnostics own;
      const bool again = phase_ == Phase::kBody && attempts_ > 0;
      const Outcome outcome = execution.advance_in(node_.name, *run_, own, again ? attempts_ + 1 : 0);
      if (outcome == Outcome::kRunning) return outcome;
      run_.reset();
      if (phase_ == Phase::kCleanup) {
        execution.strand->protect(false);
        return finish_cleanup(outcome, own, diagnostics);
      }
      note_end(outcome, std::move(own), execution);
    }
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    // What cleans up goes on, unless the whole program ends.
    if (run_ && (phase_ != Phase::kCleanup || execution.cancelled)) run_->cancel(execution);
  }

  [[nodiscard]] Json state() const override {
    Json state{{"phase", static_cast<int>(phase_)},
               {"after", static_cast<int>(after_)},
               {"attempts", attempts_},
               {"result", static_cast<int>(result_)},
               {"variables", scope_.to_json()}};
    state["errors"] = diagnostics_to_json(failure_);
    if (run_) state["run"] = run_->state();
    return state;
  }
  void restore(const Json& state, Execution& execution, Diagnostics& diagnostics) override {
    const int phase = state.value("phase", 0);
    if (phase < 0 || phase > static_cast<int>(Phase::kCleanup)) throw std::out_of_range("there is no such phase");
    phase_ = static_cast<Phase>(phase);
    after_ = static_cast<Phase>(std::clamp(state.value("after", 0), 0, static_cast<int>(Phase::kCleanup)));
    attempts_ = state.value("attempts", std::int64_t{0});
    result_ = static_cast<Outcome>(std::clamp(state.value("result", 1), 1, 3));
    failure_ = diagnostics_from_json(state.value("errors", Json::array()));
    if (state.contains("variables") && !state.at("variables").empty()) {
      node_.declare_error(scope_, "");
      scope_.from_json(state.at("variables"));
    }
    if (!state.contains("run")) return;
    run_ = std::make_unique<SettledRun>(part().begin(scope_));
    run_->restore(state.at("run"), execution, diagnostics);
  }

 private:
  /// kRest: after a failure, until no arm brakes.
  enum class Phase { kBody, kRest, kRecover, kHandler, kCleanup };

  [[nodiscard]] const Node& part() const {
    switch (phase_) {
      case Phase::kRecover:
        return *node_.recover;
      case Phase::kHandler:
        return *node_.handler;
      case Phase::kCleanup:
        return *node_.cleanup;
      default:
        return *node_.body;
    }
  }

  void enter(Phase phase) { phase_ = phase; }

  /// The body, an attempt to recover or the handler has ended.
  void note_end(Outcome outcome, Diagnostics own, Execution& execution) {
    if (outcome == Outcome::kDone && phase_ == Phase::kRecover) return enter(Phase::kBody);
    if (outcome != Outcome::kFailed) {
      failure_ = {};
      result_ = outcome;
      return enter(Phase::kCleanup);
    }
    // A motion that was left open before is not the body's: whoever is around handles that.
    const int failed = execution.strand->failed();
    const bool of_others = failed != failed_before_ && failed <= *opened_before_;
    failed_before_ = failed;
    const bool of_handler = phase_ == Phase::kHandler;
    if (of_handler) {
      failure_.append(own);
    } else {
      failure_ = std::move(own);
    }
    result_ = Outcome::kFailed;
    const bool again = phase_ == Phase::kBody && attempts_ < node_.retry && !cancelled_ && !of_others;
    const bool handle = !of_handler && node_.handles && !cancelled_ && !of_others;
    after_ = again ? Phase::kRecover : handle ? Phase::kHandler : Phase::kCleanup;
    rest_until_ = execution.context.core.cycle() +
                  static_cast<std::int64_t>(kRestTime_s / to_seconds(execution.context.core.period()));
    enter(Phase::kRest);
  }

  /// No arm of the cell is on its braking ramp.
  [[nodiscard]] bool at_rest(const Execution& execution) const {
    if (execution.context.core.cycle() >= rest_until_) return true;
    return std::ranges::all_of(execution.context.cell.arms, [](const auto& entry) {
      return entry.second.device->phase() != device::Arm::Phase::kBraking;
    });
  }

  void after_rest(Execution& execution) {
    enter(after_);
    const std::string text = messages_of(failure_);
    if (phase_ == Phase::kRecover) {
      ++attempts_;
      execution.context.event("program", "retry",
                              fmt::format("{} ({} of {}): {}", node_.name, attempts_, node_.retry, text));
    } else if (phase_ == Phase::kHandler) {
      execution.context.event("program", "handled", fmt::format("{}: {}", node_.name, text));
    }
    node_.declare_error(scope_, text);
  }

  Outcome finish_cleanup(Outcome outcome, const Diagnostics& own, Diagnostics& diagnostics) {
    if (outcome == Outcome::kFailed) failure_.append(own);
    if (outcome != Outcome::kDone) result_ = outcome;
    return end(diagnostics);
  }

  Outcome end(Diagnostics& diagnostics) {
    diagnostics.append(failure_);
    return result_;
  }

  const TryNode& node_;
  Scope scope_;
  Phase phase_ = Phase::kBody, after_ = Phase::kCleanup;
  std::int64_t attempts_ = 0, rest_until_ = 0;
  std::optional<int> opened_before_;  ///< motions that the strand had left open when this began
  int failed_before_ = 0;
  Outcome result_ = Outcome::kDone;
  Diagnostics failure_;
  std::unique_ptr<NodeRun> run_;
  bool cancelled_ = false;
};

std::unique_ptr<NodeRun> TryNode::begin(Scope& scope) const { return std::make_unique<TryRun>(*this, scope); }

void read_handler(ObjectReader& parent, TryNode& node, NodeParser& parser) {
  const Json* json = parent.object("on_error", false);
  node.handles = json != nullptr;
  static const Json kNothing{{"steps", Json::array()}};
  ObjectReader reader(json ? *json : kNothing, parent.at("on_error"), parser.diagnostics());
  const NodeParser::Inner inner(parser);
  node.as = reader.text("as", "");
  if (!node.as.empty() && !is_variable_name(node.as)) {
    parser.diagnostics().error(Code::kInvalidName, reader.at("as"), fmt::format("invalid variable name '{}'", node.as),
                               "Use letters, digits and _");
    node.as.clear();
  }
  if (!node.as.empty()) parser.scope().declare(node.as, {Type::text(), Value::unknown(Type::text()), {}});
  node.handler = parser.steps(reader, "steps");
  reader.finish();
}

}  // namespace

std::unique_ptr<Node> parse_try(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<TryNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "try");
  FormReader from(try_form(), reader);
  if (reader.has("retry")) node->retry = from.integer("retry");
  const NodeParser::Inner inner(parser);
  node->body = parser.steps(reader, "steps");
  node->recover = parser.steps(reader, "recover", false);
  read_handler(reader, *node, parser);
  node->cleanup = parser.steps(reader, "finally", false);
  from.check_rules();
  reader.finish();
  return node;
}

}  // namespace takt::program
