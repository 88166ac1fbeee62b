#include "core/operations/command_step.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/mode_change.h"
#include "core/command/actions/motion_action.h"
#include "core/command/check.h"
#include "core/command/external_watch.h"
#include "core/command/mapping.h"
#include "core/net/compiled_net.h"
#include "core/operations/command_request.h"
#include "core/operations/compliance_request.h"
#include "core/operations/made_tree.h"
#include "core/operations/net_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// What is told at a key already is not told again of its command.
void add_news(const Findings& more, Findings& found) {
  for (const Finding& one : more.list()) {
    const bool told = std::ranges::any_of(found.list(), [&](const Finding& other) {
      return other.message == one.message && other.pointer.starts_with(one.pointer);
    });
    if (!told) found.add(one);
  }
}

/// Plans, checks and maps a tree. @return the net, or all findings with pointers of the file.
/// @param[in,out] places  as plan() has them
Result<command::MappedCommand> prepare(const MadeTree& tree, const command::Cell& cell, command::Places& places,
                                       Nanoseconds period) {
  Findings found;
  for (const MadeTree::Part& part : tree.parts()) part.request->check(cell, found);
  // What is planned is checked as a plan.
  const Findings planned = command::plan(tree.command(), places);
  add_news(tree.in_file(command::check(tree.command(), false)), found);
  add_news(tree.in_file(planned), found);
  if (found.has_errors()) return std::unexpected(std::move(found));
  auto mapped = command::map(tree.command(), period);
  if (!mapped) return std::unexpected(tree.in_file(mapped.error()));
  return mapped;
}

class CommandRun final : public OneNetRun {
 public:
  explicit CommandRun(const CommandRequest& root) : root_(root) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    Findings notes;
    const Making making{.cell = context.cell, .biases = context.variables.biases, .notes = notes};
    const MadeTree tree(root_, making);
    // The first step of a program may come before the first sample.
    if (!std::ranges::all_of(tree.parts(), has_told)) return Progress::kRunning;
    command::Places places;
    auto mapped = prepare(tree, context.cell, places, context.core.period());
    if (!mapped) return fail(mapped.error(), findings);
    for (const MadeTree::Part& part : tree.parts()) keys_.emplace_back(part.request, part.key);
    observed_ = std::move(mapped->observed);
    const Progress progress = load(context, mapped->net, findings, mapped->options);
    if (progress != Progress::kRunning) return progress;
    const Findings unseen = watch_.attach(context.core, net_id(), mapped->externals);
    return unseen.has_errors() ? fail(unseen, findings) : progress;
  }

  /// It is known where its arms are.
  static bool has_told(const MadeTree::Part& part) {
    if (!part.made.actuator) return true;
    return std::ranges::all_of(part.made.actuator->model().arms(),
                               [](const auto* arm) { return arm->device->set_point().q.size() > 0; });
  }

  /// Pointers are whole; those of a step are below it.
  Progress fail(const Findings& why, Findings& findings) const {
    for (Finding finding : why.list()) {
      if (finding.pointer.starts_with(root_.pointer)) finding.pointer.erase(0, root_.pointer.size());
      findings.add(std::move(finding));
    }
    return Progress::kFailed;
  }

  void after_cycle(Context& context) override {
    watch_.poll([&](const command::ExternalEvent& event) {
      context.variables.monitors[root_.name][event.name] = std::to_string(event.count);
      context.event(root_.name, "told",
                    event.cycle ? fmt::format("{} (cycle {})", event.name, *event.cycle)
                                : fmt::format("{} (cycle not known)", event.name));
    });
  }

  Progress finish(Context& context, Findings& findings) override { return ended(context, findings, false); }
  Progress finish_cancelled(Context& context, Findings& findings) override { return ended(context, findings, true); }

  Progress ended(Context& context, Findings& findings, bool cancelled) {
    if (net() == nullptr || net()->cycles() == 0) return Progress::kDone;  // it was called off before its start
    const EndedTree tree(net(), observed_);
    Findings own;
    for (const auto& [request, key] : keys_) {
      request->finish(tree, key, cancelled, context, own);
      if (request->transaction() != nullptr) keep_captures(*request, key, context);
    }
    if (!own.has_errors()) return Progress::kDone;
    return fail(own, findings);
  }

  /// What was captured, for `monitor(step, name)` in expressions.
  void keep_captures(const CommandRequest& transaction, const std::string& key, Context& context) const {
    for (const CaptureRequest& capture : transaction.transaction()->captures) {
      const auto port = observed_.find(MadeTree::capture_name(key, capture.name));
      if (port == observed_.end()) continue;
      const EndedTree tree(net(), observed_);
      const auto number = tree.value<net::Real>(port->first);
      const auto level = tree.value<net::Boolean>(port->first);
      const std::string text = number ? Json(*number).dump() : level ? Json(*level).dump() : "null";
      context.variables.monitors[root_.name][capture.name] = text;
      context.event(root_.name, capture.name, text);
    }
  }

  const CommandRequest& root_;
  std::vector<std::pair<const CommandRequest*, std::string>> keys_;
  std::map<std::string, std::string> observed_;
  command::ExternalWatch watch_;
};

class CommandStep final : public Step {
 public:
  explicit CommandStep(std::unique_ptr<CommandRequest> root) : root_(std::move(root)) {}

  /// Arms go to the natural end of what moves them; where that is not known before they stay.
  void rehearse(Rehearsal& rehearsal, const std::string&, Findings& findings) const override {
    const command::Biases untared;
    Findings notes;
    const Making making{.cell = rehearsal.cell, .biases = untared, .notes = notes};
    const MadeTree tree(*root_, making);
    command::Places places = rehearsal.q;
    const auto mapped = prepare(tree, rehearsal.cell, places, kMillisecond);
    findings.append(notes);
    if (!mapped) return findings.append(mapped.error());
    for (const MadeTree::Part& part : tree.parts()) {
      const auto mode = part.made.action ? part.made.action->model().mode() : std::nullopt;
      if (!mode) continue;
      for (const std::string& arm : part.made.actuator->model().devices())
        rehearse_mode(rehearsal, arm, *mode, part.request->pointer, findings);
    }
    rehearse_net(mapped->net, rehearsal, root_->pointer, findings);
    for (const MadeTree::Part& part : tree.parts()) {
      if (part.made.action) rehearsal.duration += part.made.command.node()->model().duration();
    }
    rehearsal.q = std::move(places);
    for (const MadeTree::Part& part : tree.parts()) part.request->rehearse(rehearsal, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<CommandRun>(*root_); }

 private:
  std::unique_ptr<CommandRequest> root_;
};

}  // namespace

std::unique_ptr<Step> parse_command_step(const Json& json, const std::string& pointer, const command::Cell& cell,
                                         Findings& findings) {
  return std::make_unique<CommandStep>(read_command_step(json, pointer, cell, findings));
}

}  // namespace takt::activity
