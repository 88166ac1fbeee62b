// Leaves of a program: steps. One whose keys hold expressions is made anew each time that it begins.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/moving_frames.h"
#include "core/activity/node.h"
#include "core/base/object_reader.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// A step as the file has it.
struct Part {
  std::string name, pointer;
  const StepKind* kind = nullptr;
  ValueTemplate piece;
  bool blends = false;  ///< into the step after it
};

/// Steps that run as one, ready to run.
struct Instance {
  std::unique_ptr<Step> made;  ///< null if the node owns the step
  const Step* step = nullptr;
  std::string name, pointer;
  std::vector<std::string> absorbed;
};

bool is_motion(const Part& part) {
  constexpr std::string_view kMotions[] = {"ptp", "lin", "circ", "spline"};
  return std::ranges::find(kMotions, part.kind->name) != std::end(kMotions);
}

class LeafNode final : public Node {
 public:
  std::vector<Part> parts;
  std::unique_ptr<Step> step;  ///< null if a part holds an expression
  std::vector<std::string> absorbed;

  [[nodiscard]] std::unique_ptr<NodeRun> begin(Scope& scope) const override;
  void rehearse(Rehearsal& rehearsal, Scope& scope, Findings& findings) const override;
  [[nodiscard]] std::int64_t count() const override { return static_cast<std::int64_t>(parts.size()); }
  void collect_names(std::vector<std::string>& names) const override {
    for (const Part& part : parts) names.push_back(part.name);
  }
  [[nodiscard]] bool constant() const override { return step != nullptr; }

  /// The steps with what their expressions are worth now. `unknown` gets expressions that are not known.
  [[nodiscard]] std::vector<Instance> instances(const Sight& sight, command::Cell& cell, Findings& findings,
                                                std::vector<std::string>& unknown) const {
    std::vector<Instance> result;
    if (step) {
      result.push_back({nullptr, step.get(), name, pointer, absorbed});
      return result;
    }
    for (const Part& part : parts) {
      const auto resolved = part.piece.resolve(sight, cell, findings);
      unknown.insert(unknown.end(), resolved.unknown.begin(), resolved.unknown.end());
      if (findings.has_errors() || !unknown.empty()) return {};
      auto made = part.kind->parse(*resolved.json, part.pointer, cell, findings);
      if (findings.has_errors()) return {};
      if (!result.empty() && result.back().made->absorb(*made)) {
        result.back().absorbed.push_back(part.name);
        continue;
      }
      const Step* const raw = made.get();
      result.push_back({std::move(made), raw, part.name, part.pointer, {}});
    }
    return result;
  }
};

class LeafRun final : public NodeRun {
 public:
  LeafRun(const LeafNode& node, Scope& scope) : node_(node), scope_(scope) {}

  Outcome advance(Execution& execution, Findings& findings) override {
    if (!begun_) {
      if (cancelled_) return Outcome::kDone;
      if (!execution.may_begin(node_)) return Outcome::kRunning;
      if (!execution.spend(node_.pointer, findings)) return Outcome::kFailed;
      if (!begin(execution, findings)) return Outcome::kFailed;
    }
    while (index_ < instances_.size()) {
      const Outcome outcome = advance_step(execution, findings);
      if (outcome != Outcome::kDone) return outcome;
    }
    return Outcome::kDone;
  }

  void cancel(Execution& execution) override {
    cancelled_ = true;
    if (run_) run_->cancel(execution.context);
  }

  [[nodiscard]] Json state() const override { return {{"begun", begun_}}; }
  void restore(const Json&, Execution&, Findings&) override {}

 private:
  bool begin(Execution& execution, Findings& findings) {
    begun_ = true;
    Findings own;
    std::vector<std::string> unknown;
    instances_ = node_.instances(execution.sight(scope_), execution.context.cell, own, unknown);
    for (const std::string& text : unknown) {
      own.error(node_.pointer, fmt::format("'{}' is not known yet when this step begins", text), "a value before");
    }
    findings.append(own);
    return !own.has_errors();
  }

  Outcome advance_step(Execution& execution, Findings& findings) {
    const Instance& instance = instances_[index_];
    if (!run_) {
      if (cancelled_) return finish();
      run_ = instance.step->begin();
      part_ = 0;
      enter(execution, instance.name);
    }
    Findings own;
    const Progress progress = run_->advance(execution.context, own);
    follow_part(execution, instance);
    if (progress == Progress::kRunning) return Outcome::kRunning;
    run_.reset();
    execution.steps_done += 1 + static_cast<std::int64_t>(instance.absorbed.size());
    leave(execution, progress == Progress::kDone ? "end" : "failed");
    ++index_;
    if (progress == Progress::kDone) return Outcome::kDone;
    findings.append(own, instance.pointer);
    return Outcome::kFailed;
  }

  Outcome finish() {
    index_ = instances_.size();
    return Outcome::kDone;
  }

  /// Tells where a step with absorbed ones has come to. Forwards only: a path may be run back.
  void follow_part(Execution& execution, const Instance& instance) {
    for (const std::size_t part = std::min(run_->part(), instance.absorbed.size()); part_ < part; ++part_) {
      leave(execution, "end");
      enter(execution, instance.absorbed[part_]);
    }
  }

  void enter(Execution& execution, const std::string& name) {
    current_ = name;
    execution.current.push_back(name);
    execution.context.event("program", "begin", name);
  }
  void leave(Execution& execution, std::string_view how) {
    execution.current.erase(std::ranges::find(execution.current, current_));
    execution.context.event("program", how, current_);
  }

  const LeafNode& node_;
  Scope& scope_;
  bool begun_ = false, cancelled_ = false;
  std::vector<Instance> instances_;
  std::size_t index_ = 0;
  std::unique_ptr<StepRun> run_;
  std::size_t part_ = 0;
  std::string current_;
};

std::unique_ptr<NodeRun> LeafNode::begin(Scope& scope) const { return std::make_unique<LeafRun>(*this, scope); }

void LeafNode::rehearse(Rehearsal& rehearsal, Scope& scope, Findings& findings) const {
  if (!spend_rehearsal(rehearsal, *this, findings)) return;
  const auto planned = [&](const std::string& arm) { return rehearsal.q[arm]; };
  see_flanges(rehearsal.cell, planned);
  Findings own;
  std::vector<std::string> unknown;
  const auto made = instances(sight_of(rehearsal, scope), rehearsal.cell, own, unknown);
  findings.append(own);
  if (own.has_errors()) return;
  if (!unknown.empty()) {
    findings.note(pointer, fmt::format("not checked before the run: '{}' is not known then", unknown.front()),
                  "\"nominal\" where the variable is declared");
    return;
  }
  for (const Instance& instance : made) {
    rehearsal.step = instance.name;
    instance.step->rehearse(rehearsal, instance.pointer, findings);
    see_flanges(rehearsal.cell, planned);
  }
}

/// Errors of form of a step with expressions: what hangs on their values shows in the rehearsal only.
void check_form(const Part& part, NodeParser& parser) {
  Findings own;
  command::Cell cell = parser.cell();
  const auto resolved = part.piece.resolve(parser.sight(), cell, own);
  parser.findings().append(own);
  Findings form;
  (void)part.kind->parse(*resolved.json, part.pointer, cell, form);
  for (const Finding& finding : form.list()) {
    // A key that nobody knows is wrong whatever its value is.
    const bool unknown_key = finding.message.starts_with("key '");
    if (unknown_key || !part.piece.depends(finding.pointer)) parser.findings().add(finding);
  }
}

}  // namespace

std::unique_ptr<Node> parse_leaf(const StepKind& kind, const Json& json, const std::string& pointer,
                                 NodeParser& parser) {
  auto leaf = std::make_unique<LeafNode>();
  leaf->pointer = pointer;
  Part part{.name = {}, .pointer = pointer, .kind = &kind, .piece = {}, .blends = false};
  part.piece = ValueTemplate::parse(json, pointer, parser.findings());
  part.blends = json.contains("blend_m") || json.contains("blend_fraction");
  const auto name = json.find("name");
  part.name = leaf->name = name != json.end() && name->is_string() ? name->get<std::string>() : std::string(kind.name);
  for (const char* key : {"do", "name"}) {
    if (part.piece.depends_on_key(key)) {
      parser.findings().error(pointer + "/" + key, fmt::format("an expression at '{}'", key), "a text that is fixed");
    }
  }
  if (part.piece.constant()) {
    command::Cell none;  // without expressions nothing is asked
    const auto resolved = part.piece.resolve(parser.sight(), none, parser.findings());
    leaf->step = kind.parse(*resolved.json, pointer, parser.cell(), parser.findings());
  } else {
    check_form(part, parser);
  }
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
    if (!leaf->parts.back().blends || !is_motion(leaf->parts.back()) || !is_motion(follower->parts.front()))
      return false;
    leaf->step.reset();
  }
  leaf->absorbed.push_back(follower->name);
  for (Part& part : follower->parts) leaf->parts.push_back(std::move(part));
  return true;
}

}  // namespace takt::activity
