#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/command/command.h"
#include "core/operations/table/state_parameters.h"

/// What a command of a file says of events, and a transaction beside its commands. Filled once. Any thread.
namespace takt::operations {

/// "When a state is entered, or left, then ...", as a file has it.
struct HandlerParameters {
  struct Effect {
    command::Effect::Kind kind = command::Effect::Kind::kCancel;
    std::string name;     ///< of a command or raised state; of kExternal what is reported
    std::string pointer;  ///< of the name
  };
  std::string pointer;
  StateParameters state;
  bool entered = true;
  std::vector<Effect> effects;
  command::Trigger trigger;
};

/// A value that is kept under a name.
struct CaptureParameters {
  std::string name, pointer;
  ValueParameters value;
  std::optional<StateParameters> when;  ///< nothing: the last one
  std::optional<double> rate = {};      ///< Hz, at which it is shown while the transaction runs; nothing: at its end
};

/// What a transaction is beside its commands.
struct TransactionParameters {
  std::vector<std::string> raised;
  std::vector<CaptureParameters> captures;
  enum class OnCancel { kForward, kForwardTo, kIgnore } on_cancel = OnCancel::kForward;
  std::vector<std::string> forward_to;
};

}  // namespace takt::operations
