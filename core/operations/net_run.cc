#include "core/operations/net_run.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/activity/motion_activity.h"
#include "core/command/cause_text.h"

namespace takt::activity {

namespace {

/// An arm's own channels, in which its motions tell where they are: they go with the arm.
bool goes_with_an_arm(const std::string& name, const command::Cell& cell) {
  return std::ranges::any_of(cell.arms, [&](const auto& arm) {
    return name == path_time_channel(arm.first) || name == path_rate_channel(arm.first);
  });
}

/// Names of the devices that a net drives; wholes count by their parts.
void note_claims(const net::CompiledNet& net, const Rehearsal& rehearsal) {
  if (!rehearsal.claimed) return;
  for (const net::Resource* claim : net.claims()) {
    const auto* device = dynamic_cast<const device::Device*>(claim);
    if (device != nullptr && !goes_with_an_arm(device->name(), rehearsal.cell))
      rehearsal.claimed->insert(device->name());
  }
}

}  // namespace

void rehearse_net(const net::NetDescription& description, const Rehearsal& rehearsal, const std::string& pointer,
                  Findings& findings) {
  if (rehearsal.nets) rehearsal.nets->push_back({rehearsal.step, pointer, description});
  if (!rehearsal.devices) return;
  const auto net = net::CompiledNet::compile(description, *rehearsal.devices);
  if (net) return note_claims(**net, rehearsal);
  for (const Finding& finding : net.error().list()) {
    findings.error(pointer, fmt::format("in the net of this step, {}: {}", finding.pointer, finding.message),
                   finding.hint);
  }
}

NetRun::~NetRun() {
  if (core_) (void)core_->unload(id_);
}

Progress NetRun::begin(Context& context, const net::NetDescription& description, const rcc::LoadOptions& options,
                       Findings& findings) {
  auto id = context.core.load(description, options);
  if (!id) {
    findings.append(id.error());
    return Progress::kFailed;
  }
  core_ = &context.core;
  id_ = *id;
  start_cycle_ = context.core.cycle() + context.program_latency_cycles;
  return advance(context, findings);
}

Progress NetRun::advance(Context& context, Findings& findings) {
  if (start_request_ == 0) {
    if (cancelled_) return Progress::kDone;
    if (context.core.cycle() >= start_cycle_) start_request_ = context.core.start(id_);
    return Progress::kRunning;
  }
  for (const rcc::Event& event : context.core.events()) {
    if (event.kind != rcc::Event::Kind::kRefused || event.request != start_request_) continue;
    findings.error({}, fmt::format("the net was not started: {}", event.cause.text.view()),
                   "\"try\" around the step, where the program can go on");
    return Progress::kFailed;
  }
  const rcc::NetStatus status = context.core.status(id_);
  if (cancelled_ && status.state == rcc::NetState::kRunning) context.core.cancel(id_);
  if (status.state != rcc::NetState::kTerminated) return Progress::kRunning;
  const auto code = status.cause.code;
  if (status.cause.in_order()) return Progress::kDone;
  findings.error({},
                 fmt::format("the net was stopped in cycle {} ({}): {}", status.last_cycle, name_of(code),
                             command::cause_text(status.cause, context.cell)),
                 "\"try\" around the step, where the program can go on");
  return Progress::kFailed;
}

Progress OneNetRun::advance(Context& context, Findings& findings) {
  if (!net_.begun()) return begin(context, findings);
  after_cycle(context);
  const Progress progress = net_.advance(context, findings);
  if (progress != Progress::kDone) return progress;
  return net_.cancelled() ? finish_cancelled(context, findings) : finish(context, findings);
}

}  // namespace takt::activity
