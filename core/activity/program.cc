#include "core/activity/program.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// More steps than this without a cycle between them are a program that never waits.
constexpr int kStepBudget = 10'000;

/// More steps than this are not counted: repetitions inside repetitions go beyond any integer.
constexpr std::int64_t kMostSteps = 1'000'000'000'000;

std::int64_t count_steps(const Node& node) {
  if (node.step) return 1 + static_cast<std::int64_t>(node.absorbed.size());
  std::int64_t count = 0;
  for (const Node& child : node.children) count = std::min(kMostSteps, count + count_steps(child));
  return std::min(kMostSteps, count * node.times);
}

Node parse_node(const Json& json, const std::string& pointer, const command::Cell& cell, Findings& findings);

/// A step may take the one after it into itself.
void add_child(Node child, Node& sequence) {
  Node* last = sequence.children.empty() ? nullptr : &sequence.children.back();
  if (last && last->step && child.step && last->step->absorb(*child.step)) {
    last->absorbed.push_back(child.name);
  } else {
    sequence.children.push_back(std::move(child));
  }
}

void parse_sequence(const Json& json, const command::Cell& cell, Findings& findings, Node& node) {
  ObjectReader reader(json, node.pointer, findings);
  (void)reader.text("do");
  node.name = reader.text("name", "sequence");
  node.times = reader.integer("times", 1, {.low = 0, .high = 1e6});
  if (const Json* steps = reader.array("steps")) {
    for (std::size_t i = 0; i < steps->size(); ++i) {
      add_child(parse_node((*steps)[i], reader.at("steps") + pointer_segment(i), cell, findings), node);
    }
  }
  // A million rounds of nothing would keep the runner busy without ever meeting a step.
  if (count_steps(node) == 0) node.times = 0;
  reader.finish();
}

/// Recursion is bounded by the depth that JSON files may have.
Node parse_node(const Json& json, const std::string& pointer, const command::Cell& cell, Findings& findings) {
  Node node;
  node.pointer = pointer;
  Findings unread;
  ObjectReader head(json, pointer, json.is_object() ? unread : findings);
  const std::string kind = head.text("do", "");
  node.name = head.text("name", kind);
  if (!json.is_object()) return node;
  if (kind == "sequence") {
    parse_sequence(json, cell, findings, node);
    return node;
  }
  const auto& kinds = step_kinds();
  const auto found = std::ranges::find(kinds, kind, &StepKind::name);
  if (found != kinds.end()) {
    node.step = found->parse(json, pointer, cell, findings);
    return node;
  }
  std::vector<std::string> names{"sequence"};
  for (const StepKind& known : kinds) names.emplace_back(known.name);
  findings.error(pointer + "/do", kind.empty() ? "'do' is missing" : fmt::format("there is no step '{}'", kind),
                 nearest_choice(kind, names, 30));
  return node;
}

/// One round of a sequence shows whatever the form of the steps can show; a second one starts where the first ended.
/// Inside a second round one round is enough, or the effort would double with each level. The others are taken to last
/// as long as the last one that was played.
/// @param most_rounds  of each sequence, 1 or 2
void rehearse_node(const Node& node, std::int64_t most_rounds, Rehearsal& rehearsal, Findings& findings) {
  if (node.step) {
    rehearsal.step = node.name;
    return node.step->rehearse(rehearsal, node.pointer, findings);
  }
  const std::int64_t rounds = std::min(node.times, most_rounds);
  double last_round = 0.0;
  for (std::int64_t round = 0; round < rounds; ++round) {
    const double begin = rehearsal.duration;
    for (const Node& child : node.children) rehearse_node(child, round == 0 ? most_rounds : 1, rehearsal, findings);
    if (findings.has_errors()) return;
    last_round = rehearsal.duration - begin;
  }
  rehearsal.duration += static_cast<double>(node.times - rounds) * last_round;
}

void collect_names(const Node& node, std::vector<std::string>& names) {
  names.push_back(node.name);
  names.insert(names.end(), node.absorbed.begin(), node.absorbed.end());
  for (const Node& child : node.children) collect_names(child, names);
}

}  // namespace

Result<Program> Program::parse(const Json& json, const std::string& pointer, const command::Cell& cell) {
  Findings findings;
  Program program;
  program.root_ = parse_node(json, pointer, cell, findings);
  if (findings.has_errors()) return std::unexpected(std::move(findings));
  return program;
}

Rehearsed Program::rehearse(const command::Cell& cell, net::Environment* devices,
                            std::vector<RehearsedNet>* nets) const {
  Rehearsal rehearsal;
  rehearsal.nets = nets;
  rehearsal.cell = cell;
  rehearsal.devices = devices;
  for (const auto& [name, arm] : cell.arms) rehearsal.q[name] = arm.start;
  Findings findings;
  rehearse_node(root_, 2, rehearsal, findings);
  return {std::move(findings), rehearsal.duration, std::move(rehearsal.estimates)};
}

std::int64_t Program::step_count() const { return count_steps(root_); }

std::vector<std::string> Program::names() const {
  std::vector<std::string> names;
  collect_names(root_, names);
  return names;
}

ProgramRunner::ProgramRunner(const Program& program, Context& context) : program_(program), context_(context) {
  stack_.push_back({&program_.root()});
}

/// Moves to the next leaf. @return false at the end of the program.
bool ProgramRunner::enter_next() {
  while (!stack_.empty()) {
    Position& top = stack_.back();
    const Node& node = *top.node;
    if (node.step && top.round == 0) {
      top.round = 1;
      leaf_ = &node;
      return true;
    }
    if (node.step || node.children.empty() || top.round >= node.times) {
      stack_.pop_back();
    } else if (top.child < node.children.size()) {
      const Node& child = node.children[top.child++];
      stack_.push_back({&child});
    } else {
      top.child = 0;
      ++top.round;
    }
  }
  return false;
}

Progress ProgramRunner::advance() {
  for (int budget = kStepBudget; progress_ == Progress::kRunning; --budget) {
    if (!run_) {
      if (cancelled_ || !enter_next()) {
        progress_ = Progress::kDone;
        current_.clear();
        break;
      }
      if (budget == 0) {
        findings_.error(leaf_->pointer, fmt::format("{} steps without a single cycle between them", kStepBudget),
                        "a wait or a motion inside the sequence");
        progress_ = Progress::kFailed;
        break;
      }
      run_ = leaf_->step->begin();
      current_ = leaf_->name;
      part_ = 0;
      context_.event("program", "begin", current_);
    }
    Findings findings;
    const Progress progress = run_->advance(context_, findings);
    follow_part();
    if (progress == Progress::kRunning) break;
    run_.reset();
    steps_done_ += 1 + static_cast<std::int64_t>(leaf_->absorbed.size());
    context_.event("program", progress == Progress::kDone ? "end" : "failed", current_);
    if (progress == Progress::kFailed) {
      findings_.append(findings, leaf_->pointer);
      progress_ = Progress::kFailed;
    }
  }
  return progress_;
}

/// Tells where a leaf with absorbed steps has come to. Forwards only: a path may be run back.
void ProgramRunner::follow_part() {
  for (const std::size_t part = std::min(run_->part(), leaf_->absorbed.size()); part_ < part; ++part_) {
    context_.event("program", "end", current_);
    current_ = leaf_->absorbed[part_];
    context_.event("program", "begin", current_);
  }
}

void ProgramRunner::cancel() {
  cancelled_ = true;
  if (run_) run_->cancel(context_);
}

}  // namespace takt::activity
