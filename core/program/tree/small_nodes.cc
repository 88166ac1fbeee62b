// Nodes that are done at once, and the wait for an expression.
#include <algorithm>
#include <functional>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/question.h"
#include "core/program/tree/strand.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

/// A node that is done in the moment in which it begins.
class ImmediateNode : public Node {
 public:
  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;
  [[nodiscard]] std::int64_t count() const override { return 1; }
  virtual Outcome act(Execution& execution, Scope& scope, Diagnostics& diagnostics) const = 0;
  /// It reads machines, or ends something: a motion that was left open has to be over.
  [[nodiscard]] virtual bool needs_settled_state(const expression::Cell& cell) const = 0;
};

class ImmediateRun final : public NodeRun {
 public:
  ImmediateRun(const ImmediateNode& node, Scope& scope) : node_(node), scope_(scope) {}
  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (cancelled_) return Outcome::kDone;
    const bool looks = node_.needs_settled_state(execution.context.cell);
    if (const Outcome ready = looks ? settle(execution, diagnostics) : Outcome::kDone; ready != Outcome::kDone)
      return ready;
    if (!execution.may_begin(node_)) return Outcome::kRunning;
    if (!execution.charge(node_.pointer, diagnostics)) return Outcome::kFailed;
    ++execution.steps_done;
    return node_.act(execution, scope_, diagnostics);
  }
  void cancel(Execution&) override { cancelled_ = true; }
  [[nodiscard]] Json state() const override { return Json::object(); }
  void restore(const Json&, Execution&, Diagnostics&) override {}

 private:
  const ImmediateNode& node_;
  Scope& scope_;
  bool cancelled_ = false;
};

std::unique_ptr<NodeRun> ImmediateNode::begin(Scope& scope) const {
  return std::make_unique<ImmediateRun>(*this, scope);
}

/// Evaluates; the diagnostics go to `diagnostics` too. @return true if there were none.
bool evaluate(const ValueTemplate& piece, const EvalContext& eval_context, Value& value, Diagnostics& diagnostics) {
  Diagnostics own;
  value = piece.value(eval_context, own);
  diagnostics.append(own);
  return !own.has_errors();
}

// -- let -----------------------------------------------------------------------------------------------------------

class LetNode final : public ImmediateNode {
 public:
  std::vector<std::pair<std::string, ValueTemplate>> values;

  void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const override {
    if (spend_rehearsal(rehearsal, *this, diagnostics)) assign(sight_of(rehearsal, scope), scope, diagnostics, {});
  }
  Outcome act(Execution& execution, Scope& scope, Diagnostics& diagnostics) const override {
    const auto tell = [&](const std::string& text) { execution.context.event("program", "let", text); };
    return assign(execution.eval_context(scope), scope, diagnostics, tell) ? Outcome::kDone : Outcome::kFailed;
  }
  [[nodiscard]] bool constant() const override { return false; }
  [[nodiscard]] bool needs_settled_state(const expression::Cell& cell) const override {
    return std::ranges::any_of(values, [&](const auto& value) { return value.second.changes(cell); });
  }

 private:
  /// One after the other: a later one sees the earlier.
  bool assign(const EvalContext& eval_context, Scope& scope, Diagnostics& diagnostics,
              const std::function<void(const std::string&)>& tell) const {
    for (const auto& [target, piece] : values) {
      Value value;
      if (!evaluate(piece, eval_context, value, diagnostics)) return false;
      Variable& variable = *scope.find(target);
      if (!accepts(variable.type, value.type)) {
        diagnostics.error(
            Code::kTypeMismatch, piece.pointer(),
            fmt::format("'{}' is a {}, but the value is a {}", target, to_string(variable.type), to_string(value.type)),
            fmt::format("Give a {}", to_string(variable.type)));
        return false;
      }
      scope.assign(variable, std::move(value), eval_context.rehearsing());
      if (tell) tell(fmt::format("{} = {}", target, to_string(variable.value)));
    }
    return true;
  }
};

// -- log and fail --------------------------------------------------------------------------------------------------

/// Says something, and fails or not.
class TextNode final : public ImmediateNode {
 public:
  ValueTemplate text;
  bool fails = false;

  void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const override {
    (void)text.value(sight_of(rehearsal, scope), diagnostics);
  }
  Outcome act(Execution& execution, Scope& scope, Diagnostics& diagnostics) const override {
    Value value;
    if (!evaluate(text, execution.eval_context(scope), value, diagnostics)) return Outcome::kFailed;
    const std::string words = to_string(value);
    if (!fails) {
      execution.context.event("program", "log", words);
      return Outcome::kDone;
    }
    execution.context.event("program", "failed", fmt::format("{}: {}", name, words));
    diagnostics.error(Code::kRaised, pointer, words);
    return Outcome::kFailed;
  }
  [[nodiscard]] bool constant() const override { return text.constant(); }
  [[nodiscard]] bool needs_settled_state(const expression::Cell& cell) const override {
    return fails || text.changes(cell);
  }
};

class StopNode final : public ImmediateNode {
 public:
  void rehearse(operations::Rehearsal&, Scope&, Diagnostics&) const override {}
  Outcome act(Execution& execution, Scope&, Diagnostics&) const override {
    execution.context.event("program", "stop", name);
    return Outcome::kStopped;
  }
  [[nodiscard]] bool constant() const override { return true; }
  [[nodiscard]] bool needs_settled_state(const expression::Cell&) const override { return true; }
};

// -- wait for an expression ----------------------------------------------------------------------------------------

class UntilNode final : public Node {
 public:
  ValueTemplate until;
  std::optional<double> timeout;  ///< s

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;
  void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const override {
    operations::settle_rehearsal(rehearsal, diagnostics);
    if (spend_rehearsal(rehearsal, *this, diagnostics)) (void)until.value(sight_of(rehearsal, scope), diagnostics);
  }
  [[nodiscard]] std::int64_t count() const override { return 1; }
  [[nodiscard]] bool constant() const override { return until.constant(); }
};

/// Asks between all cycles; what is not known does not hold yet.
class UntilRun final : public NodeRun {
 public:
  UntilRun(const UntilNode& node, Scope& scope) : node_(node), scope_(scope) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (begun_ < 0) {
      if (cancelled_) return Outcome::kDone;
      if (const Outcome ready = settle(execution, diagnostics); ready != Outcome::kDone) return ready;
      if (!execution.may_begin(node_)) return Outcome::kRunning;
      if (!execution.charge(node_.pointer, diagnostics)) return Outcome::kFailed;
      begun_ = execution.context.core.cycle();
      execution.enter(node_.name);
    }
    const Outcome outcome = look(execution, diagnostics);
    if (outcome == Outcome::kRunning) return outcome;
    ++execution.steps_done;
    execution.leave(node_.name, outcome == Outcome::kDone ? "end" : "failed", messages_of(diagnostics));
    return outcome;
  }
  void cancel(Execution&) override { cancelled_ = true; }
  [[nodiscard]] Json state() const override { return Json::object(); }
  void restore(const Json&, Execution&, Diagnostics&) override {}

 private:
  Outcome look(Execution& execution, Diagnostics& diagnostics) {
    Value value;
    if (!evaluate(node_.until, execution.eval_context(scope_), value, diagnostics)) return Outcome::kFailed;
    if (cancelled_ || (!value.null() && value.boolean())) return Outcome::kDone;
    const double waited =
        static_cast<double>(execution.context.core.cycle() - begun_) * to_seconds(execution.context.core.period());
    if (!node_.timeout || waited < *node_.timeout) return Outcome::kRunning;
    diagnostics.error(Code::kTimeout, node_.pointer + "/until",
                      fmt::format("this did not hold within {:g} s", *node_.timeout),
                      "Increase \"timeout_s\", or put \"try\" around it");
    return Outcome::kFailed;
  }

  const UntilNode& node_;
  Scope& scope_;
  std::int64_t begun_ = -1;
  bool cancelled_ = false;
};

std::unique_ptr<NodeRun> UntilNode::begin(Scope& scope) const { return std::make_unique<UntilRun>(*this, scope); }

std::unique_ptr<Node> parse_text(const Json& json, const std::string& pointer, NodeParser& parser, bool fails) {
  auto node = std::make_unique<TextNode>();
  node->pointer = pointer;
  node->fails = fails;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, fails ? "fail" : "log");
  if (const Json* text = reader.child("text")) {
    node->text = parser.value(*text, reader.at("text"), Type::text());
  } else {
    parser.diagnostics().error(Code::kMissing, pointer, "key 'text' is missing", "Give a text, or \"$...\"");
  }
  reader.finish();
  return node;
}

}  // namespace

std::unique_ptr<Node> parse_let(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<LetNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "let");
  const Json none = Json::object();
  const Json* values = reader.object("values");
  for (const auto& [name, value] : (values ? *values : none).items()) {
    const std::string place = reader.at("values") + pointer_segment(name);
    const Variable* variable = parser.scope().find(name);
    if (!variable) {
      parser.diagnostics().error(Code::kUnknownName, place, fmt::format("there is no variable '{}'", name),
                                 nearest_choice(name, parser.scope().names()));
    }
    node->values.emplace_back(name, parser.value(value, place, variable ? variable->type : Type{}));
  }
  reader.finish();
  return node;
}

std::unique_ptr<Node> parse_log(const Json& json, const std::string& pointer, NodeParser& parser) {
  return parse_text(json, pointer, parser, false);
}

std::unique_ptr<Node> parse_fail(const Json& json, const std::string& pointer, NodeParser& parser) {
  return parse_text(json, pointer, parser, true);
}

std::unique_ptr<Node> parse_stop(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<StopNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "stop");
  reader.finish();
  return node;
}

std::unique_ptr<Node> parse_until(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<UntilNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "wait");
  node->until = parser.value(*reader.child("until"), reader.at("until"), Type::boolean());
  if (reader.has("timeout_s")) node->timeout = reader.number("timeout_s", {}, {.low = 0, .high = 3600});
  reader.finish();
  return node;
}

}  // namespace takt::program
