#pragma once

#include <concepts>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/activity_run.h"
#include "core/collision/contact_rules.h"
#include "core/command/command.h"
#include "core/expression/believed_shapes.h"
#include "core/expression/condition_state.h"
#include "core/operations/table/compliance.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/step.h"
#include "core/operations/table/transaction_parameters.h"
#include "core/rcc/control_core.h"

/// Operations as commands: what a step "transaction" is made of (docs/programs.md), and operations of programs in C++.
/// Read or filled once; made into commands of the command layer each time they begin.
namespace takt::operations {

/// What commands are made with.
struct BuildContext {
  const expression::Cell& cell;
  const expression::Biases& biases;
  Diagnostics& notes;                                   ///< gets what planners have to say, with pointers of the file
  std::optional<expression::RealSensor> progress = {};  ///< of the command that this one follows()
  std::optional<command::Action> followed = {};         ///< the same command's action; nothing: it has none
  command::ExternalHandler tell = {};                   ///< gets external effects
  activity::ConcurrentMotions meanwhile = {};           ///< what others do while a `move` is carried out
  std::optional<expression::FingerWidths> widths =
      {};                ///< of grippers, as they are believed to stand; default: measured
  bool is_part = false;  ///< of a composition: something may come after it in the same net
};

/// One command that was made. Nothing that it does itself is set: for a wait or a transaction.
struct MadeCommand {
  command::Command command;
  std::optional<command::Action> action = {};
  std::optional<command::Actuator> actuator = {};
  std::vector<std::string> handler_places = {};  ///< of each handler that it has already: below its pointer
  /// Locations below its pointer in the file that the command layer names otherwise: theirs, ours.
  std::vector<std::pair<std::string, std::string>> places = {};
};

/// An operation as a command. Immutable once its tree is read.
///
/// What operations that move an arm have in common is done here: `compliance` by on_actuator(), `abort_if` for any
/// command, without a line of its own in the operation (docs/operations.md).
class OperationCommand {
 public:
  OperationCommand() = default;
  virtual ~OperationCommand() = default;
  OperationCommand(const OperationCommand&) = delete;
  OperationCommand& operator=(const OperationCommand&) = delete;

  /// What make() gives, cancelled as soon as `abort_if` holds or is unknown.
  /// @param key  with which the names of what it observes begin
  [[nodiscard]] MadeCommand made(const BuildContext& build, const std::string& key) const;
  /// What has come of it once the tree has ended in order: `abort_if`, and what finish() says.
  /// @param cancelled  the whole was cancelled
  void report(const activity::RunView& ended, const std::string& key, bool cancelled, activity::Context& context,
              Diagnostics& diagnostics) const;

  /// The command, named as this, without what `on` says. Not of transactions.
  /// @param key  with which the names of what it observes begin
  [[nodiscard]] virtual MadeCommand make(const BuildContext& build, const std::string& key) const = 0;
  /// Its command is called by its type, whatever its step is called: what it drives says which one it is.
  [[nodiscard]] virtual bool is_called_by_type() const { return false; }
  /// Of a planned motion that asks for a blend: the arm, and its motions as steps of a file; empty: it comes to rest.
  [[nodiscard]] virtual std::string left_arm() const { return {}; }
  [[nodiscard]] virtual nlohmann::ordered_json left_steps() const;
  /// Its motions that find their own paths.
  struct OwnPaths {
    std::string arm;
    std::vector<std::string> pointers = {};  ///< of each; none: it has none
  };
  [[nodiscard]] virtual OwnPaths own_paths() const { return {}; }
  /// The name of the command whose progress it follows; empty: none. That one is made before.
  [[nodiscard]] virtual std::string follows() const { return {}; }
  /// What it means to touch while it runs (docs/world.md).
  struct IntendedContact {
    collision::Touching devices = {};  ///< arms with their tools, grippers
    std::size_t first_motion = 0;      ///< of several motions that are one: not before this one
    bool ends = false;                 ///< the first touch ends it
  };
  /// By default nothing.
  [[nodiscard]] virtual IntendedContact meant_touch() const { return {}; }
  /// The tools that it works with, alone and not of commands inside.
  [[nodiscard]] virtual ArmTools arm_tools() const { return arm_tool_ ? ArmTools{*arm_tool_} : ArmTools(); }
  /// Figures that its device does not have; with whole pointers.
  virtual void check(const expression::Cell&, Diagnostics&) const {}
  /// What it leaves in a rehearsal beside the positions of the arms: time, what is touched or carried.
  virtual void rehearse(Rehearsal&, Diagnostics&) const {}
  /// What has come of it once the tree has ended in order: results for the program; diagnostics, with whole pointers,
  /// if it has failed. @param cancelled  the whole was cancelled
  virtual void finish(const activity::RunView&, const std::string& key, bool cancelled, activity::Context&,
                      Diagnostics&) const {
    (void)key;
    (void)cancelled;
  }

  /// Null but of a transaction.
  [[nodiscard]] const TransactionParameters* transaction() const { return transaction_.get(); }
  [[nodiscard]] const std::vector<std::unique_ptr<OperationCommand>>& parts() const { return parts_; }
  [[nodiscard]] const OperationCommand* parent() const { return parent_; }
  /// It is a step, or an activity, of its own, and no part of a transaction or of a composition.
  [[nodiscard]] bool is_alone(const BuildContext& build) const { return parent_ == nullptr && !build.is_part; }
  [[nodiscard]] bool is_alone(const activity::RunView& run) const { return parent_ == nullptr && run.is_whole(); }
  /// The command that a name means here: one directly inside, itself, or one around; "a/b" is b inside of a.
  [[nodiscard]] const OperationCommand* find(std::string_view name) const;
  /// The transaction that declares a raised state: this or around, else any of the tree (rule C10 checks).
  [[nodiscard]] const OperationCommand* find_raised(const std::string& state) const;
  /// All commands of the tree below this one, itself first.
  [[nodiscard]] std::vector<const OperationCommand*> all() const;

  std::string name, pointer;
  bool starts = false;  ///< in the cycle in which its transaction does
  std::vector<HandlerParameters> handlers;

 protected:
  /// @param parameters  of which `compliance` and `abort_if` are kept, where they have them
  template <class Parameters>
  requires(!std::derived_from<Parameters, OperationCommand>) explicit OperationCommand(const Parameters& parameters) {
    if constexpr (requires { parameters.compliance; }) compliance_ = parameters.compliance;
    if constexpr (requires { parameters.abort_if; }) abort_if_ = parameters.abort_if;
    if constexpr (requires { parameters.tool.tcp; })
      arm_tool_ = ArmTool{parameters.arm, parameters.tool, parameters.pointer};
  }
  /// The action on an actuator, with the compliance of the parameters.
  [[nodiscard]] MadeCommand on_actuator(const command::Actuator& actuator, const command::Action& action) const;
  [[nodiscard]] const std::optional<ComplianceParameters>& compliance() const { return compliance_; }

  void adopt(std::unique_ptr<OperationCommand> part) {
    part->parent_ = this;
    parts_.push_back(std::move(part));
  }

  std::unique_ptr<TransactionParameters> transaction_;

 private:
  std::optional<ComplianceParameters> compliance_;
  std::optional<expression::StateSource> abort_if_;
  std::optional<ArmTool> arm_tool_;
  std::vector<std::unique_ptr<OperationCommand>> parts_;
  const OperationCommand* parent_ = nullptr;
};

/// Reads a command with what it says of events; its "do" says of which type it is. Never null: with diagnostics it may
/// be one that is never made. Names of commands and raised states are not checked (step_of_command()). Realtime:
/// setup.
[[nodiscard]] std::unique_ptr<OperationCommand> read_any_command(const OperationSource& source);

}  // namespace takt::operations
