#include "core/program/tree/program.h"

#include <algorithm>
#include <exception>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/activity/held_parts.h"
#include "core/expression/moving_frames.h"
#include "core/program/tree/measured_json.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

/// Rounds that are played find the same again.
Diagnostics each_once(const Diagnostics& diagnostics) {
  Diagnostics result;
  std::set<std::string> seen;
  for (const Diagnostic& diagnostic : diagnostics.list()) {
    if (seen.insert(to_string(diagnostic)).second) result.add(diagnostic);
  }
  return result;
}

/// The scopes in the state of a node, with those of the nodes in it.
void collect_variables(const Json& state, const std::string& place,
                       std::map<std::string, ProgramRunner::Known>& found) {
  if (!state.is_structured()) return;
  for (const auto& [key, value] : state.items()) {
    if (key != "variables") {
      collect_variables(value, place + pointer_segment(key), found);
      continue;
    }
    for (const auto& [name, variable] : value.items())
      found[place + pointer_segment(name)] = {name, to_string(value_from_json(variable))};
  }
}

/// In real time a plan may come many cycles after it was asked for: a motion that is to be left in motion is taken over
/// later.
activity::Scheduler::Options options_of(const activity::Context& context) {
  activity::Scheduler::Options options{.latency_cycles = context.program_latency_cycles};
  if (context.realtime != nullptr) options.margin_cycles = activity::RealtimeSupport::kMargin;
  return options;
}

}  // namespace

Result<Program> Program::parse(const Json& json, const std::string& pointer, const expression::Cell& cell,
                               const Json* programs) {
  Diagnostics diagnostics;
  NodeParser parser(cell, programs, diagnostics);
  const NodeParser::Inner variables(parser);
  Program program;
  program.root_ = parser.node(json, pointer);
  parser.all_programs();
  program.programs_ = parser.programs();
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  program.warnings_ = std::move(diagnostics);
  return program;
}

Rehearsed Program::rehearse(const expression::Cell& cell, net::Environment* devices,
                            std::vector<operations::RehearsedNet>* nets) const {
  operations::Rehearsal rehearsal;
  rehearsal.nets = nets;
  rehearsal.cell = cell;
  rehearsal.devices = devices;
  for (const auto& [name, arm] : cell.arms) {
    rehearsal.q[name] = arm.start;
    if (arm.device != nullptr) rehearsal.modes[name] = arm.device->mode();
  }
  std::vector<activity::FoundCollision> collisions;
  rehearsal.collisions.found = &collisions;
  Diagnostics diagnostics = warnings_;
  Scope scope;
  operations::check_start(rehearsal, diagnostics);
  root_->rehearse(rehearsal, scope, diagnostics);
  operations::settle_rehearsal(rehearsal, diagnostics);
  return {each_once(diagnostics), rehearsal.duration, std::move(rehearsal.estimates), std::move(collisions),
          std::move(rehearsal.collisions.meanwhile.spaces)};
}

std::vector<std::string> Program::names() const {
  std::vector<std::string> names;
  root_->collect_names(names);
  for (const auto& program : programs_) program->body->collect_names(names);
  return names;
}

ProgramRunner::ProgramRunner(const Program& program, activity::Context& context)
    : program_(program),
      scheduler_(context.core, context.cell, options_of(context),
                 context.realtime != nullptr ? *context.realtime : activity::RealtimeSupport{}),
      execution_(context),
      run_(std::make_unique<SettledRun>(program.root().begin(scope_))) {
  context.scheduler = &scheduler_;
  scheduler_.set_alone(true);
  execution_.strand = &strand_;
}

ProgramRunner::~ProgramRunner() {
  if (execution_.context.scheduler == &scheduler_) execution_.context.scheduler = nullptr;
}

operations::Progress ProgramRunner::advance() {
  if (progress_ != operations::Progress::kRunning) return progress_;
  execution_.asking.clear();
  expression::update_flange_frames(execution_.context.cell);
  scheduler_.poll();
  const Outcome outcome = run_->advance(execution_, diagnostics_);
  scheduler_.poll();  // what was asked for just now
  notice_lost_parts(execution_.context);
  activity::notice_lost_tools(execution_.context);
  show_current();
  if (outcome == Outcome::kRunning) return progress_;
  progress_ = outcome == Outcome::kFailed ? operations::Progress::kFailed : operations::Progress::kDone;
  // A step that failed is still shown.
  if (progress_ == operations::Progress::kDone) current_.clear(), paths_.clear();
  return progress_;
}

void ProgramRunner::show_current() {
  if (execution_.current == shown_ || execution_.current.empty()) return;
  shown_ = execution_.current;
  current_.clear();
  paths_.clear();
  for (const auto& [name, path] : shown_) {
    current_ += (current_.empty() ? "" : " + ") + name;
    paths_ += (paths_.empty() ? "" : " + ") + path;
  }
}

std::string ProgramRunner::path() const {
  const std::string now = execution_.path();
  return now.empty() ? paths_ : now;
}

void ProgramRunner::cancel() {
  execution_.cancelled = true;
  run_->cancel(execution_);
}

Json ProgramRunner::snapshot() const {
  Json snapshot{{"cycle", execution_.context.core.cycle()}, {"steps_done", execution_.steps_done}};
  snapshot["measured"] = measured_to_json(execution_.context.variables, execution_.context.cell);
  snapshot["position"] = run_->state();
  if (Json open = strand_.state(); !open.is_null()) snapshot["open"] = std::move(open);
  return snapshot;
}

std::map<std::string, ProgramRunner::Known> ProgramRunner::variables() const {
  std::map<std::string, Known> found;
  collect_variables(run_->state(), {}, found);
  return found;
}

Diagnostics ProgramRunner::restore(const Json& snapshot) {
  Diagnostics diagnostics;
  try {
    diagnostics.append(
        measured_from_json(snapshot.at("measured"), execution_.context.variables, execution_.context.cell),
        "/measured");
    execution_.steps_done = snapshot.at("steps_done").get<std::int64_t>();
    diagnostics.append(put_back(snapshot.at("position")), "/position");
    strand_.restore(snapshot.value("open", Json()), execution_, diagnostics);
  } catch (const std::exception& error) {
    diagnostics.error(Code::kWrongType, {}, fmt::format("this is not a state of this program: {}", error.what()),
                      "Give what snapshot() gave for the same file");
  }
  return diagnostics;
}

Diagnostics ProgramRunner::enter(std::string_view name) {
  const auto state = program_.root().state_before(name);
  if (state) return put_back(*state);
  Diagnostics diagnostics;
  diagnostics.error(Code::kUnknownName, {}, fmt::format("no step '{}' can be entered", name),
                    nearest_choice(name, program_.names()));
  return diagnostics;
}

Diagnostics ProgramRunner::put_back(const Json& state) {
  Diagnostics diagnostics;
  try {
    run_ = std::make_unique<SettledRun>(program_.root().begin(scope_));
    run_->restore(state, execution_, diagnostics);
  } catch (const std::exception& error) {
    diagnostics.error(Code::kWrongType, {}, fmt::format("this is not a state of this program: {}", error.what()),
                      "Give what snapshot() gave for the same file");
  }
  return diagnostics;
}

}  // namespace takt::program
