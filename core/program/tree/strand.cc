#include "core/program/tree/strand.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/outcome_json.h"

namespace takt::program {

using Json = nlohmann::ordered_json;

const std::string& ControlLine::open_arm() const {
  static const std::string kNone;
  return open_ ? open_->arm : kNone;
}

operations::Progress ControlLine::advance(Execution& execution, Diagnostics& diagnostics) {
  if (!open_) return operations::Progress::kDone;
  Diagnostics own;
  const operations::Progress progress = open_->run->advance(execution.context, own);
  if (progress == operations::Progress::kRunning) return progress;
  diagnostics.append(own, open_->pointer);
  if (progress == operations::Progress::kFailed) failed_ = opened_;
  close(execution, progress == operations::Progress::kDone ? "end" : "failed");
  return progress;
}

Outcome settle(Execution& execution, Diagnostics& diagnostics) {
  return execution.strand->settle(Outcome::kDone, execution, diagnostics);
}

Outcome settle_for(Execution& execution, const ValueTemplate& piece, Diagnostics& diagnostics) {
  return piece.changes(execution.context.cell) ? settle(execution, diagnostics) : Outcome::kDone;
}

Outcome settle_for(Execution& execution, const std::vector<Declaration>& declarations, Diagnostics& diagnostics) {
  const auto changes = [&](const Declaration& one) {
    return one.initial && one.initial->changes(execution.context.cell);
  };
  return std::ranges::any_of(declarations, changes) ? settle(execution, diagnostics) : Outcome::kDone;
}

Outcome ControlLine::settle(Outcome outcome, Execution& execution, Diagnostics& diagnostics) {
  if (outcome == Outcome::kFailed && open_) open_->run->cancel(execution.context);
  const operations::Progress progress = advance(execution, diagnostics);
  if (progress == operations::Progress::kRunning) return Outcome::kRunning;
  return progress == operations::Progress::kFailed ? Outcome::kFailed : outcome;
}

void ControlLine::cancel(Execution& execution) {
  if (open_ && (protected_ == 0 || execution.cancelled)) open_->run->cancel(execution.context);
}

void ControlLine::close(Execution& execution, std::string_view how) {
  if (!open_) return;
  execution.steps_done += open_->parts;
  execution.leave(open_->name, how);
  open_.reset();
}

Json ControlLine::state() const {
  if (!open_) return {};
  return {{"pointer", open_->pointer}, {"steps", *open_->steps}, {"frames", *open_->frames}};
}

void ControlLine::restore(const Json& state, Execution& execution, Diagnostics& diagnostics) {
  if (state.is_null()) return;
  OpenStep open;
  open.pointer = state.at("pointer").get<std::string>();
  open.steps = std::make_shared<Json>(state.at("steps"));
  open.frames = std::make_shared<Json>(state.at("frames"));
  for (const auto& [frame, pose] : open.frames->items()) {
    diagnostics.append(
        execution.context.cell.frames.set(frame, std::string(world::FrameGraph::kWorld), pose_from_json(pose)));
  }
  open.parts = 0;
  for (const Json& json : *open.steps) {
    const operations::Operation* operation = operations::Operations::global().find(json.at("do").get<std::string>());
    if (operation == nullptr || operation->read_step == nullptr) throw std::out_of_range("there is no such step");
    Diagnostics own;
    auto step = operation->read_step({json, open.pointer, execution.context.cell, own});
    diagnostics.append(own);
    if (own.has_errors()) return;
    if (!open.step) open.name = json.value("name", std::string(operation->name));
    if (!open.step) {
      open.step = std::move(step);
    } else if (!open.step->absorb(*step)) {
      throw std::out_of_range("these steps are not one motion");
    }
    ++open.parts;
  }
  if (!open.step) return;
  open.arm = open.step->moved_arm();
  open.run = open.step->begin();
  execution.enter(open.name);
  leave_open(std::move(open));
  (void)advance(execution, diagnostics);
}

Json keep_frames(Json& steps, const world::FrameGraph& frames) {
  Json kept = Json::object();
  for (Json& value : steps) {
    if (value.is_structured()) {
      kept.update(keep_frames(value, frames));
    } else if (value.is_string() && value.get_ref<const std::string&>().starts_with("$/")) {
      const auto frame = value.get<std::string>();
      const auto X_WF = frames.pose(frame);
      if (!X_WF) continue;
      value = "open " + frame;
      kept["open " + frame] = pose_to_json(*X_WF);
    }
  }
  return kept;
}

Outcome SettledRun::advance(Execution& execution, Diagnostics& diagnostics) {
  ControlLine& strand = *execution.strand;
  if (!opened_before_) opened_before_ = strand.opened();
  if (!ended_) {
    const Outcome outcome = run_->advance(execution, diagnostics_);
    if (outcome == Outcome::kRunning) return outcome;
    ended_ = outcome;
  }
  const bool of_others = strand.opened() == *opened_before_;
  const Outcome outcome = of_others ? *ended_ : strand.settle(*ended_, execution, diagnostics_);
  if (outcome != Outcome::kRunning) diagnostics.append(diagnostics_);
  return outcome;
}

Json SettledRun::state() const {
  Json state = run_->state();
  if (ended_)
    state["ended"] = {{"outcome", outcome_to_json(*ended_)}, {"diagnostics", diagnostics_to_json(diagnostics_)}};
  return state;
}

void SettledRun::restore(const Json& state, Execution& execution, Diagnostics& diagnostics) {
  opened_before_ = execution.strand->opened();
  if (!state.contains("ended")) return run_->restore(state, execution, diagnostics);
  ended_ = outcome_from_json(state.at("ended").at("outcome"));
  diagnostics_ = diagnostics_from_json(state.at("ended").at("diagnostics"));
}

void SettledRun::cancel(Execution& execution) {
  if (!ended_) run_->cancel(execution);
  execution.strand->cancel(execution);
}

}  // namespace takt::program
