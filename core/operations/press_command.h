#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/command/command.h"
#include "core/operations/force_request.h"
#include "core/operations/step.h"

/// What steps and commands of a transaction that press have in common. Realtime: setup.
namespace takt::activity {

/// A press, or a search, as an action; with its compliance.
[[nodiscard]] command::Action press_action(const ForceRequest& request, const PreparedPress& prepared,
                                           const command::Cell& cell, const command::Biases& biases);
/// The same where it is not known yet from where the arm will begin: planned then. It refers to both.
[[nodiscard]] command::Action press_from_anywhere(const ForceRequest& request, const command::Cell& cell,
                                                  const command::Biases& biases);

/// The command, with all that ends it.
struct PressingCommand {
  command::RuntimeCommand command;
  std::vector<std::string> handler_places;  ///< of each of its handlers: below the step
};
/// @param key  with which the names of what it keeps begin
[[nodiscard]] PressingCommand pressing_command(const ForceRequest& request, const std::string& name,
                                               const command::Action& action, const command::Cell& cell,
                                               const command::Biases& biases, const std::string& key);

/// Where the tool stood in the arm's base, by the name under which it was kept; nothing: it never was.
using KeptPlaces = std::function<std::optional<net::Frame>(const std::string& name)>;
/// What has come of it once it has ended in order: the touch of its arm; diagnostics, with pointers below the step, if
/// it has failed. @param cancelled  somebody has cancelled it, so that it may end anywhere
[[nodiscard]] Diagnostics end_pressing(const ForceRequest& request, const KeptPlaces& kept, const std::string& key,
                                       bool cancelled, Context& context);

}  // namespace takt::activity
