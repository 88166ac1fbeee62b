#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/activity_run.h"
#include "core/command/command.h"
#include "core/operations/state_request.h"
#include "core/operations/step.h"
#include "core/rcc/control_core.h"

/// Commands as files have them: what stands in a step "transaction" (docs/programs.md). Read once; made into commands
/// of the command layer each time their step begins.
namespace takt::activity {

class CommandRequest;

/// What commands are made with.
struct BuildContext {
  const command::Cell& cell;
  const command::Biases& biases;
  Diagnostics& notes;                                ///< gets what planners have to say, with pointers of the file
  std::optional<command::RealSensor> progress = {};  ///< of the command that this one follows()
  command::ExternalHandler tell = {};                ///< hears of external effects
};

/// One command that was made. Nothing that it does itself is set: for a wait or a transaction.
struct MadeCommand {
  command::Command command;
  std::optional<command::Action> action = {};
  std::optional<command::Actuator> actuator = {};
  std::vector<std::string> handler_places = {};  ///< of each handler that it has already: below its pointer
  /// Where below its pointer things stand in the file that the command layer calls otherwise: theirs, ours.
  std::vector<std::pair<std::string, std::string>> places = {};
};

/// "When a state is entered, or left, then ...", as a file has it.
struct HandlerRequest {
  struct Effect {
    command::Effect::Kind kind = command::Effect::Kind::kCancel;
    std::string name;     ///< of a command or raised state; of kExternal what is told
    std::string pointer;  ///< where the name stands
  };
  std::string pointer;
  StateRequest state;
  bool entered = true;
  std::vector<Effect> effects;
  command::Trigger trigger;
};

/// A value that is kept under a name.
struct CaptureRequest {
  std::string name, pointer;
  ValueRequest value;
  std::optional<StateRequest> when;  ///< nothing: the last one
};

/// What a transaction is beside its commands.
struct TransactionRequest {
  std::vector<std::string> raised;
  std::vector<CaptureRequest> captures;
  enum class OnCancel { kForward, kForwardTo, kIgnore } on_cancel = OnCancel::kForward;
  std::vector<std::string> forward_to;
};

/// A command of a file. Immutable once its tree is read.
class CommandRequest {
 public:
  CommandRequest() = default;
  virtual ~CommandRequest() = default;
  CommandRequest(const CommandRequest&) = delete;
  CommandRequest& operator=(const CommandRequest&) = delete;

  /// The command, named as this, without what `on` says. Not of transactions.
  /// @param key  with which the names of what it observes begin
  [[nodiscard]] virtual MadeCommand make(const BuildContext& making, const std::string& key) const = 0;
  /// The name of the command whose progress it follows; empty: none. That one is made before.
  [[nodiscard]] virtual std::string follows() const { return {}; }
  /// Figures that its device does not have; with whole pointers.
  virtual void check(const command::Cell&, Diagnostics&) const {}
  /// What it leaves in a rehearsal beside the places of the arms: time, what is touched or carried.
  virtual void rehearse(Rehearsal&, Diagnostics&) const {}
  /// What has come of it once the tree has ended in order: results for the program; diagnostics, with whole pointers,
  /// if it has failed. @param cancelled  somebody has cancelled the whole
  virtual void finish(const ActivityRun&, const std::string& key, bool cancelled, Context&, Diagnostics&) const {
    (void)key;
    (void)cancelled;
  }

  /// Null but of a transaction.
  [[nodiscard]] const TransactionRequest* transaction() const { return transaction_.get(); }
  [[nodiscard]] const std::vector<std::unique_ptr<CommandRequest>>& parts() const { return parts_; }
  [[nodiscard]] const CommandRequest* parent() const { return parent_; }
  /// The command that a name means here: one directly inside, itself, or one around; "a/b" is b inside of a.
  [[nodiscard]] const CommandRequest* find(std::string_view name) const;
  /// The transaction that declares a raised state: this or around, else any of the tree (rule C10 tells).
  [[nodiscard]] const CommandRequest* find_raised(const std::string& state) const;
  /// All commands of the tree below this one, itself first.
  [[nodiscard]] std::vector<const CommandRequest*> all() const;

  std::string name, pointer;
  bool starts = false;  ///< in the cycle in which its transaction does
  std::vector<HandlerRequest> handlers;

 protected:
  std::unique_ptr<TransactionRequest> transaction_;
  std::vector<std::unique_ptr<CommandRequest>> parts_;

 private:
  friend std::unique_ptr<CommandRequest> read_transaction(const nlohmann::ordered_json&, const std::string&,
                                                          const command::Cell&, Diagnostics&);
  const CommandRequest* parent_ = nullptr;
};

/// A kind of command: the word after "do", and how to read it.
struct CommandKind {
  std::string_view name;
  std::unique_ptr<CommandRequest> (*read)(const nlohmann::ordered_json& json, const std::string& pointer,
                                          const command::Cell& cell, Diagnostics& diagnostics);
};
/// All kinds, by name.
[[nodiscard]] const std::vector<CommandKind>& command_kinds();
/// The parameters of a transaction beside what its commands have.
[[nodiscard]] const std::vector<ParameterInfo>& transaction_parameter_list();

/// Reads a command that is a step of its own, with all in it. Diagnostics: all that is wrong with its form, names of
/// commands and raised states included. Never null. Realtime: setup.
[[nodiscard]] std::unique_ptr<CommandRequest> read_command_step(const nlohmann::ordered_json& json,
                                                                const std::string& pointer, const command::Cell& cell,
                                                                Diagnostics& diagnostics);

// Readers of the kinds.
std::unique_ptr<CommandRequest> read_transaction(const nlohmann::ordered_json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_ptp_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_lin_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics);
/// "lin" with "base_to".
std::unique_ptr<CommandRequest> read_carried_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                     const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_circ_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_spline_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                    const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_motions_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                     const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_press_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                   const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_search_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                    const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_grip_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_release_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                     const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_set_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_wait_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_hold_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_jog_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics);
std::unique_ptr<CommandRequest> read_follow_command(const nlohmann::ordered_json& json, const std::string& pointer,
                                                    const command::Cell& cell, Diagnostics& diagnostics);

}  // namespace takt::activity
