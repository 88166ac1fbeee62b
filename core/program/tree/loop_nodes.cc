// Repetition: a number of times, while or until something holds, for each element of a list.
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/node_forms.h"
#include "core/program/tree/question.h"
#include "core/program/tree/strand.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

// -- repeat --------------------------------------------------------------------------------------------------------

class RepeatNode final : public Node {
 public:
  enum class Kind { kTimes, kWhile, kUntil };
  Kind kind = Kind::kTimes;
  ValueTemplate times;
  Question condition;
  std::int64_t at_most = 10'000;
  std::string as;  ///< variable that counts the rounds from 0; may be empty
  std::unique_ptr<Node> body;

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;

  /// As often as nominal values say; twice where they do not.
  void rehearse(operations::Rehearsal& rehearsal, Scope& around, Diagnostics& diagnostics) const override {
    Scope scope(&around);
    declare_counter(scope);
    const auto fixed = kind == Kind::kTimes ? rounds(sight_of(rehearsal, scope), diagnostics) : std::nullopt;
    constexpr std::int64_t kBlind = 2;
    const bool blind = kind == Kind::kTimes && !fixed;
    const std::int64_t most = blind ? kBlind : fixed.value_or(at_most);
    const std::int64_t worth_playing = body->constant() && as.empty() ? std::min(most, kBlind) : most;
    std::int64_t unknown = 0;
    double last_round = 0.0;
    std::int64_t round = 0;
    for (; round < worth_playing && spend_rehearsal(rehearsal, *this, diagnostics); ++round) {
      if (kind == Kind::kWhile && !goes_on(rehearsal, scope, diagnostics, unknown)) return;
      count_round(scope, round);
      Diagnostics own;
      const double begin = rehearsal.duration;
      body->rehearse(rehearsal, scope, own);
      last_round = rehearsal.duration - begin;
      diagnostics.append(own);
      if (own.has_errors()) return;
      if (kind == Kind::kUntil && !goes_on(rehearsal, scope, diagnostics, unknown)) return;
    }
    if (fixed) rehearsal.duration += static_cast<double>(*fixed - round) * last_round;
  }

  [[nodiscard]] std::int64_t count() const override {
    Diagnostics none;
    const auto fixed = kind == Kind::kTimes && times.constant() ? rounds({}, none) : std::nullopt;
    return saturated(fixed.value_or(1), body->count());
  }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    body->collect_names(names);
  }
  [[nodiscard]] bool constant() const override {
    return as.empty() && times.constant() && condition.piece().constant() && body->constant();
  }
  [[nodiscard]] std::optional<Json> state_before(std::string_view wanted) const override {
    if (const auto own = Node::state_before(wanted)) return own;
    auto inside = body->state_before(wanted);
    return inside ? std::optional(Json{{"round", 0}, {"run", std::move(*inside)}}) : std::nullopt;
  }

  /// How often; nothing if it is not known, or with diagnostics if it is no number of rounds.
  [[nodiscard]] std::optional<std::int64_t> rounds(const EvalContext& eval_context, Diagnostics& diagnostics) const {
    const Value value = times.value(eval_context, diagnostics);
    if (value.null()) return std::nullopt;
    const double number = value.type.kind == Type::Kind::kNumber ? value.number() : -1.0;
    if (number >= 0 && number <= 1e6 && number == std::floor(number)) return static_cast<std::int64_t>(number);
    diagnostics.error(Code::kOutOfRange, pointer + "/times", fmt::format("{} rounds", to_string(value)),
                      "Give a whole number from 0 to 1000000");
    return std::nullopt;
  }
  void declare_counter(Scope& scope) const {
    if (!as.empty()) scope.declare(as, {Type::number(), Value::of(0.0), {}});
  }
  void count_round(Scope& scope, std::int64_t round) const {
    if (!as.empty()) scope.find(as)->value = Value::of(static_cast<double>(round));
  }

 private:
  /// On nominal values: two rounds where the condition is not known.
  bool goes_on(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics, std::int64_t& unknown) const {
    const auto holds = condition.rehearse(rehearsal, scope, diagnostics);
    if (!holds) return ++unknown < 3 && !diagnostics.has_errors();
    return *holds == (kind == Kind::kWhile);
  }
};

class RepeatRun final : public NodeRun {
 public:
  RepeatRun(const RepeatNode& node, Scope& around) : node_(node), scope_(&around) { node_.declare_counter(scope_); }

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    for (;;) {
      if (!run_) {
        const Outcome ready = prepare(execution, diagnostics);
        if (ready != Outcome::kRunning || !run_) return ready;
      }
      const Outcome outcome = execution.advance_in(node_.name, *run_, diagnostics, round_ + 1);
      if (outcome == Outcome::kRunning) return outcome;
      run_.reset();
      if (outcome != Outcome::kDone) return outcome;
      ++round_;
      // "until" is asked after a round, "while" before one.
      asked_ = node_.kind == RepeatNode::Kind::kTimes;
      if (!execution.charge_round(mark_, node_.pointer, diagnostics)) return Outcome::kFailed;
    }
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    if (question_) question_->cancel();
    if (run_) run_->cancel(execution);
  }

  [[nodiscard]] Json state() const override {
    Json state{{"round", round_}, {"asked", asked_}, {"variables", scope_.to_json()}};
    if (total_) state["rounds"] = *total_;
    if (run_) state["run"] = run_->state();
    return state;
  }
  void restore(const Json& state, Execution& execution, Diagnostics& diagnostics) override {
    if (!state.contains("round")) return;
    round_ = state.at("round").get<std::int64_t>();
    asked_ = state.value("asked", true);
    if (state.contains("rounds")) total_ = state.at("rounds").get<std::int64_t>();
    if (state.contains("variables")) scope_.from_json(state.at("variables"));
    if (!state.contains("run")) return;
    begin_round(execution);
    run_->restore(state.at("run"), execution, diagnostics);
  }

 private:
  /// Finds out whether there is another round, and begins it. @return kRunning without a run: the answer is not there.
  Outcome prepare(Execution& execution, Diagnostics& diagnostics) {
    if (cancelled_) return Outcome::kDone;
    if (node_.kind == RepeatNode::Kind::kTimes) {
      if (!total_) {
        const Outcome ready = settle_for(execution, node_.times, diagnostics);
        if (ready != Outcome::kDone) return ready;
        if (!find_total(execution, diagnostics)) return Outcome::kFailed;
      }
      if (round_ >= *total_) return Outcome::kDone;
    } else if (!asked_ && (node_.kind == RepeatNode::Kind::kWhile || round_ > 0)) {
      const Outcome answer = ask(execution, diagnostics);
      if (answer != Outcome::kRunning || !asked_) return answer;
    }
    if (round_ >= node_.at_most && node_.kind != RepeatNode::Kind::kTimes) return too_often(diagnostics);
    begin_round(execution);
    return Outcome::kRunning;
  }

  void begin_round(Execution& execution) {
    mark_ = execution.begun;
    node_.count_round(scope_, round_);
    run_ = node_.body->begin(scope_);
  }

  bool find_total(Execution& execution, Diagnostics& diagnostics) {
    Diagnostics own;
    total_ = node_.rounds(execution.eval_context(scope_), own);
    if (!total_ && !own.has_errors())
      own.error(Code::kNotKnownYet, node_.pointer + "/times", "the number of rounds is not known",
                "Give it a value before: known(x) asks");
    diagnostics.append(own);
    return total_.has_value();
  }

  Outcome ask(Execution& execution, Diagnostics& diagnostics) {
    if (!question_) question_.emplace(node_.condition, scope_);
    const operations::Progress progress = question_->advance(execution, diagnostics);
    if (progress == operations::Progress::kRunning) return Outcome::kRunning;
    const bool holds = progress == operations::Progress::kDone && question_->answer();
    question_.reset();
    if (cancelled_) return Outcome::kDone;
    if (progress == operations::Progress::kFailed) return Outcome::kFailed;
    if (holds != (node_.kind == RepeatNode::Kind::kWhile)) return Outcome::kDone;
    asked_ = true;
    return Outcome::kRunning;
  }

  Outcome too_often(Diagnostics& diagnostics) const {
    diagnostics.error(Code::kConditionNotMet, node_.pointer,
                      fmt::format("'{}' was not finished after {} rounds", node_.name, node_.at_most),
                      "Increase at_most, or let the condition come true before");
    return Outcome::kFailed;
  }

  const RepeatNode& node_;
  Scope scope_;
  std::int64_t round_ = 0, mark_ = 0;
  std::optional<std::int64_t> total_;
  bool asked_ = false, cancelled_ = false;
  std::optional<QuestionRun> question_;
  std::unique_ptr<NodeRun> run_;
};

std::unique_ptr<NodeRun> RepeatNode::begin(Scope& scope) const { return std::make_unique<RepeatRun>(*this, scope); }

// -- for_each ------------------------------------------------------------------------------------------------------

/// Poses in rows, columns and layers.
struct Grid {
  ValueTemplate place;
  std::array<std::int64_t, 3> count{1, 1, 1};
  std::array<double, 3> step{0, 0, 0};
};

class ForEachNode final : public Node {
 public:
  std::string as, index;
  ValueTemplate list;
  std::optional<Grid> grid;
  Type element;
  std::unique_ptr<Node> body;

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;

  void rehearse(operations::Rehearsal& rehearsal, Scope& around, Diagnostics& diagnostics) const override {
    Scope scope(&around);
    auto elements = values(sight_of(rehearsal, around), diagnostics);
    // Nothing is known of the list: one round shows the form.
    if (!elements) elements = std::vector<Value>{Value::unknown(element)};
    for (std::size_t i = 0; i < elements->size() && spend_rehearsal(rehearsal, *this, diagnostics); ++i) {
      set(scope, (*elements)[i], i);
      Diagnostics own;
      body->rehearse(rehearsal, scope, own);
      diagnostics.append(own);
      if (own.has_errors()) return;
    }
  }

  [[nodiscard]] std::int64_t count() const override {
    Diagnostics none;
    const auto elements = grid || list.constant() ? values({.mode = EvalContext::Mode::kRehearse}, none) : std::nullopt;
    return saturated(elements ? static_cast<std::int64_t>(elements->size()) : 1, body->count());
  }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    body->collect_names(names);
  }
  [[nodiscard]] bool constant() const override { return false; }
  [[nodiscard]] std::optional<Json> state_before(std::string_view wanted) const override {
    if (const auto own = Node::state_before(wanted)) return own;
    auto inside = body->state_before(wanted);
    return inside ? std::optional(Json{{"at", 0}, {"run", std::move(*inside)}}) : std::nullopt;
  }

  /// What the elements are made from.
  [[nodiscard]] const ValueTemplate& elements() const { return grid ? grid->place : list; }
  /// The elements; nothing if they are not known.
  [[nodiscard]] std::optional<std::vector<Value>> values(const EvalContext& eval_context,
                                                         Diagnostics& diagnostics) const {
    if (!grid) {
      const Value value = list.value(eval_context, diagnostics);
      return value.data.index() == 5 ? std::optional(value.list()) : std::nullopt;
    }
    const Value first = grid->place.value(eval_context, diagnostics);
    std::vector<Value> poses;
    for (std::int64_t z = 0; z < grid->count[2]; ++z) {
      for (std::int64_t y = 0; y < grid->count[1]; ++y) {
        for (std::int64_t x = 0; x < grid->count[0]; ++x) poses.push_back(cell_of_grid(first, {x, y, z}));
      }
    }
    return poses;
  }
  void set(Scope& scope, const Value& value, std::size_t i) const {
    Type type = element;
    if (type.kind == Type::Kind::kUnknown) type = value.type;
    scope.declare(as, {type, value, {}});
    if (!index.empty()) scope.declare(index, {Type::number(), Value::of(static_cast<double>(i)), {}});
  }

 private:
  [[nodiscard]] Value cell_of_grid(const Value& first, const std::array<std::int64_t, 3>& at) const {
    if (first.null()) return Value::unknown(Type::pose());
    Eigen::Isometry3d X = first.pose();
    Eigen::Vector3d step;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      step[axis] = static_cast<double>(at[i]) * grid->step[i];
    }
    X.translation() += X.linear() * step;
    return Value::of(X);
  }
};

class ForEachRun final : public NodeRun {
 public:
  ForEachRun(const ForEachNode& node, Scope& around) : node_(node), parent_(around), scope_(&around) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (!values_) {
      const Outcome ready = settle_for(execution, node_.elements(), diagnostics);
      if (ready != Outcome::kDone) return ready;
      if (!find_values(execution, diagnostics)) return Outcome::kFailed;
    }
    for (;;) {
      if (!run_) {
        if (cancelled_ || at_ >= values_->size()) return Outcome::kDone;
        begin_round(execution);
      }
      const auto round = static_cast<std::int64_t>(at_) + 1;
      const Outcome outcome = execution.advance_in(node_.name, *run_, diagnostics, round);
      if (outcome == Outcome::kRunning) return outcome;
      run_.reset();
      if (outcome != Outcome::kDone) return outcome;
      ++at_;
      if (!execution.charge_round(mark_, node_.pointer, diagnostics)) return Outcome::kFailed;
    }
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    if (run_) run_->cancel(execution);
  }

  /// The elements are those of the beginning, so they belong to the state.
  [[nodiscard]] Json state() const override {
    if (!values_) return Json::object();
    Json list = Json::array();
    for (const Value& value : *values_) list.push_back(to_json(value));
    Json state{{"at", at_}, {"values", std::move(list)}};
    if (run_) state["run"] = run_->state();
    return state;
  }
  void restore(const Json& state, Execution& execution, Diagnostics& diagnostics) override {
    if (!state.contains("at")) return;
    at_ = state.at("at").get<std::size_t>();
    if (state.contains("values")) {
      values_.emplace();
      for (const Json& value : state.at("values")) values_->push_back(value_from_json(value));
    } else if (!find_values(execution, diagnostics)) {
      return;
    }
    if (!state.contains("run")) return;
    if (at_ >= values_->size()) throw std::out_of_range("there is no such element");
    begin_round(execution);
    run_->restore(state.at("run"), execution, diagnostics);
  }

 private:
  bool find_values(Execution& execution, Diagnostics& diagnostics) {
    Diagnostics own;
    values_ = node_.values(execution.eval_context(parent_), own);
    if (!values_ && !own.has_errors())
      own.error(Code::kNotKnownYet, node_.pointer + "/in", "the list is not known yet",
                "Give it a value before: known(x) asks");
    const bool found = !own.has_errors();
    diagnostics.append(own);
    return found;
  }
  void begin_round(Execution& execution) {
    mark_ = execution.begun;
    node_.set(scope_, (*values_)[at_], at_);
    run_ = node_.body->begin(scope_);
  }

  const ForEachNode& node_;
  Scope& parent_;
  Scope scope_;
  std::optional<std::vector<Value>> values_;
  std::size_t at_ = 0;
  std::int64_t mark_ = 0;
  bool cancelled_ = false;
  std::unique_ptr<NodeRun> run_;
};

std::unique_ptr<NodeRun> ForEachNode::begin(Scope& scope) const { return std::make_unique<ForEachRun>(*this, scope); }

// -- Parsing -------------------------------------------------------------------------------------------------------

/// The name of a variable of a loop; it is seen in the loop only.
std::string read_variable(ObjectReader& reader, std::string_view key, bool required, const Type& type,
                          NodeParser& parser) {
  const std::string name = required ? reader.text(key) : reader.text(key, "");
  if (!reader.has(key)) return {};
  if (!is_variable_name(name)) {
    parser.diagnostics().error(Code::kInvalidName, reader.at(key), fmt::format("invalid variable name '{}'", name),
                               "Use letters, digits and _, and none of the words of expressions");
    return {};
  }
  parser.scope().declare(name, {type, Value::unknown(type), {}});
  return name;
}

Grid read_grid(const Json& json, const std::string& pointer, NodeParser& parser) {
  ObjectReader reader(json, pointer, parser.diagnostics());
  Grid grid;
  FormReader from(grid_form(), reader);
  const auto counts = reader.numbers("count", 3, {}, from.row("count").element->range);
  const auto steps = reader.numbers("step_m", 3);
  for (std::size_t i = 0; i < 3; ++i) {
    grid.count[i] = static_cast<std::int64_t>(counts[i]);
    grid.step[i] = steps[i];
    if (counts[i] == std::floor(counts[i])) continue;
    parser.diagnostics().error(Code::kOutOfRange, reader.at("count") + pointer_segment(i),
                               fmt::format("{:g} grid points", counts[i]), "Give a whole number");
  }
  if (const double all = counts[0] * counts[1] * counts[2]; all > 1e4)
    parser.diagnostics().error(Code::kOutOfRange, reader.at("count"), fmt::format("{:g} grid points", all),
                               "Use at most 10000");
  Json place = Json::object();
  for (const char* key : {"in", "position_m", "rpy_deg", "quaternion"}) {
    if (const Json* value = reader.child(key)) place[key] = *value;
  }
  reader.finish();
  grid.place = parser.value(place, pointer, Type::pose());
  return grid;
}

}  // namespace

std::unique_ptr<Node> parse_repeat(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<RepeatNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "repeat");
  const NodeParser::Inner inner(parser);
  if (reader.has("as")) node->as = read_variable(reader, "as", false, Type::number(), parser);
  const Json* times = reader.child("times");
  const Json* when = reader.child("while");
  const Json* until = reader.child("until");
  FormReader from(repeat_form(), reader);
  from.check_rules();
  (void)reader.child("at_most");
  if (times) {
    const std::size_t before = parser.diagnostics().list().size();
    node->times = parser.value(*times, reader.at("times"), Type::number());
    if (node->times.constant() && parser.diagnostics().list().size() == before)
      (void)node->rounds({}, parser.diagnostics());
  } else if (when || until) {
    node->kind = when ? RepeatNode::Kind::kWhile : RepeatNode::Kind::kUntil;
    node->condition = Question::parse(when ? *when : *until, reader.at(when ? "while" : "until"), parser);
    node->at_most = from.integer("at_most");
  }
  node->body = parser.steps(reader, "steps");
  reader.finish();
  return node;
}

std::unique_ptr<Node> parse_for_each(const Json& json, const std::string& pointer, NodeParser& parser) {
  auto node = std::make_unique<ForEachNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "for_each");
  const Json* list = reader.child("in");
  const Json* grid = reader.object("grid", false);
  FormReader(for_each_form(), reader).check_rules();
  if (grid) {
    node->grid = read_grid(*grid, reader.at("grid"), parser);
    node->element = Type::pose();
  } else if (list) {
    Type type;
    node->list = parser.value(*list, reader.at("in"), Type::list_of({}), &type);
    if (type.kind == Type::Kind::kList) node->element = type.element.front();
  }
  const NodeParser::Inner inner(parser);
  node->as = read_variable(reader, "as", true, node->element, parser);
  node->index = read_variable(reader, "index", false, Type::number(), parser);
  node->body = parser.steps(reader, "steps");
  reader.finish();
  return node;
}

}  // namespace takt::program
