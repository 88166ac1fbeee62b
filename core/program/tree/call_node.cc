// Programs that are called by name, with parameters and a result.
#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/node.h"
#include "core/program/tree/strand.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

class CallNode final : public Node {
 public:
  std::shared_ptr<const SubProgram> program;
  std::map<std::string, ValueTemplate, std::less<>> arguments;
  std::string as;  ///< variable that gets the result; may be empty

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;

  void rehearse(operations::Rehearsal& rehearsal, Scope& around, Diagnostics& diagnostics) const override {
    if (!spend_rehearsal(rehearsal, *this, diagnostics)) return;
    Scope inside;
    Diagnostics own;
    enter(sight_of(rehearsal, around), sight_of(rehearsal, inside), inside, own);
    if (!own.has_errors()) program->body->rehearse(rehearsal, inside, own);
    if (!own.has_errors()) leave(sight_of(rehearsal, inside), around, own);
    // What is wrong inside is reported there, with the call.
    for (Diagnostic diagnostic : own.list()) {
      if (!diagnostic.pointer.starts_with(pointer)) diagnostic.message += fmt::format(" (called by {})", pointer);
      diagnostics.add(std::move(diagnostic));
    }
  }

  [[nodiscard]] std::int64_t count() const override { return program->count; }
  [[nodiscard]] bool constant() const override { return false; }

  /// What it is begun with depends on where machines are.
  [[nodiscard]] bool needs_settled_state(const expression::Cell& cell) const {
    const auto looks = [&](const Declaration& one) { return one.initial && one.initial->changes(cell); };
    return std::ranges::any_of(arguments, [&](const auto& one) { return one.second.changes(cell); }) ||
           std::ranges::any_of(program->parameters, looks) || std::ranges::any_of(program->variables, looks);
  }
  /// The parameters, from what the caller gives, and the variables.
  void enter(const EvalContext& outside, const EvalContext& inside, Scope& scope, Diagnostics& diagnostics) const {
    declare(program->parameters, inside, scope, diagnostics);
    for (const auto& [parameter, argument] : arguments) {
      scope.assign(*scope.find(parameter), argument.value(outside, diagnostics), outside.rehearsing());
    }
    declare(program->variables, inside, scope, diagnostics);
  }
  void leave(const EvalContext& inside, Scope& around, Diagnostics& diagnostics) const {
    if (!program->result || as.empty()) return;
    around.assign(*around.find(as), program->result->value(inside, diagnostics), inside.rehearsing());
  }
};

class CallRun final : public NodeRun {
 public:
  CallRun(const CallNode& node, Scope& around) : node_(node), parent_(around) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (!run_) {
      if (cancelled_) return Outcome::kDone;
      if (const Outcome ready =
              node_.needs_settled_state(execution.context.cell) ? settle(execution, diagnostics) : Outcome::kDone;
          ready != Outcome::kDone)
        return ready;
      if (!execution.charge(node_.pointer, diagnostics) || !begin(execution, diagnostics)) return Outcome::kFailed;
    }
    if (!ended_) {
      std::optional<Execution::Inside> named;  // a call without a name of its own has the program's
      if (node_.name != node_.program->name) named.emplace(execution, node_.name);
      const Outcome outcome = execution.advance_in(node_.program->name, *run_, diagnostics);
      if (outcome != Outcome::kDone || cancelled_) return outcome;
      ended_ = true;
    }
    const bool tells = node_.program->result && !node_.as.empty();
    if (const Outcome ready = tells ? settle_for(execution, *node_.program->result, diagnostics) : Outcome::kDone;
        ready != Outcome::kDone || cancelled_)
      return ready;
    Diagnostics own;
    node_.leave(execution.eval_context(scope_), parent_, own);
    diagnostics.append(own);
    return own.has_errors() ? Outcome::kFailed : Outcome::kDone;
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    if (run_) run_->cancel(execution);
  }

  [[nodiscard]] Json state() const override {
    if (!run_) return Json::object();
    return {{"parameters", scope_.to_json()}, {"run", run_->state()}};
  }
  void restore(const Json& state, Execution& execution, Diagnostics& diagnostics) override {
    if (!state.contains("run") || !begin(execution, diagnostics)) return;
    scope_.from_json(state.at("parameters"));
    run_->restore(state.at("run"), execution, diagnostics);
  }

 private:
  bool begin(Execution& execution, Diagnostics& diagnostics) {
    Diagnostics own;
    node_.enter(execution.eval_context(parent_), execution.eval_context(scope_), scope_, own);
    diagnostics.append(own);
    if (own.has_errors()) return false;
    run_ = node_.program->body->begin(scope_);
    return true;
  }

  const CallNode& node_;
  Scope& parent_;
  Scope scope_;  ///< a program sees nothing of its caller
  std::unique_ptr<NodeRun> run_;
  bool cancelled_ = false, ended_ = false;
};

std::unique_ptr<NodeRun> CallNode::begin(Scope& scope) const { return std::make_unique<CallRun>(*this, scope); }

std::vector<std::string> names_of(const std::vector<Declaration>& parameters) {
  std::vector<std::string> names;
  for (const Declaration& parameter : parameters) names.push_back(parameter.name);
  return names;
}

void read_arguments(const Json& json, const std::string& pointer, CallNode& node, NodeParser& parser) {
  const auto& parameters = node.program->parameters;
  for (const auto& [name, value] : json.items()) {
    const std::string place = pointer + pointer_segment(name);
    const auto found = std::ranges::find(parameters, name, &Declaration::name);
    if (found == parameters.end()) {
      parser.diagnostics().error(Code::kUnknownName, place,
                                 fmt::format("'{}' has no parameter '{}'", node.program->name, name),
                                 nearest_choice(name, names_of(parameters)));
      continue;
    }
    node.arguments.emplace(name, parser.value(value, place, found->type));
  }
}

void read_result(ObjectReader& reader, CallNode& node, NodeParser& parser) {
  node.as = reader.text("as", "");
  if (!reader.has("as")) return;
  const Variable* variable = parser.scope().find(node.as);
  const Type& type = node.program->result_type;
  if (!variable) {
    parser.diagnostics().error(Code::kUnknownName, reader.at("as"), fmt::format("there is no variable '{}'", node.as),
                               nearest_choice(node.as, parser.scope().names()));
  } else if (!node.program->result) {
    parser.diagnostics().error(Code::kRequires, reader.at("as"), fmt::format("'{}' has no result", node.program->name),
                               "Add a \"result\" to that program, or remove \"as\"");
  } else if (!accepts(variable->type, type)) {
    parser.diagnostics().error(
        Code::kTypeMismatch, reader.at("as"),
        fmt::format("'{}' is a {}, the result a {}", node.as, to_string(variable->type), to_string(type)),
        fmt::format("Name a variable that is a {}", to_string(type)));
  }
}

}  // namespace

std::unique_ptr<Node> parse_call(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<CallNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "call");
  const std::string program = reader.text("program");
  const Json* with = reader.object("with", false);
  (void)reader.child("as");
  reader.finish();
  if (!reader.has("program")) return make_sequence({}, pointer);
  node->program = parser.program(program, reader.at("program"));
  if (!node->program) return make_sequence({}, pointer);
  if (node->name == "call") node->name = program;
  read_arguments(with ? *with : Json::object(), reader.at("with"), *node, parser);
  for (const Declaration& parameter : node->program->parameters) {
    if (parameter.initial || (with && with->contains(parameter.name))) continue;
    parser.diagnostics().error(Code::kMissing, pointer + "/with",
                               fmt::format("parameter '{}' of '{}' is missing", parameter.name, program),
                               "Give a " + to_string(parameter.type));
  }
  read_result(reader, *node, parser);
  return node;
}

}  // namespace takt::program
