#include "core/operations/table/rehearsed_net.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/activity/motion_options.h"
#include "core/command/single_net.h"
#include "core/net/compiled_net.h"

namespace takt::operations {

namespace {

/// An arm's own channels, in which its motions show their clocks: they go with the arm.
bool goes_with_an_arm(const std::string& name, const expression::Cell& cell) {
  return std::ranges::any_of(cell.arms, [&](const auto& arm) {
    return name == command::path_time_channel(arm.first) || name == command::path_rate_channel(arm.first);
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
                  Diagnostics& diagnostics) {
  if (rehearsal.nets) rehearsal.nets->push_back({rehearsal.step, pointer, description});
  if (!rehearsal.devices) return;
  const auto net = net::CompiledNet::compile(description, *rehearsal.devices);
  if (net) return note_claims(**net, rehearsal);
  for (const Diagnostic& diagnostic : net.error().list()) {
    diagnostics.error(diagnostic.code, pointer,
                      fmt::format("in the net of this step, {}: {}", diagnostic.pointer, diagnostic.message),
                      diagnostic.hint);
  }
}

void rehearse_command(const command::Command& command, const std::string& title, const Rehearsal& rehearsal,
                      const std::string& pointer, Diagnostics& diagnostics) {
  const auto mapped = command::single_net(command, title);
  if (mapped) return rehearse_net(mapped->net, rehearsal, pointer, diagnostics);
  for (Diagnostic diagnostic : mapped.error().list()) {
    diagnostic.pointer = pointer;  // those of the command mean nothing in a file
    diagnostics.add(std::move(diagnostic));
  }
}

}  // namespace takt::operations
