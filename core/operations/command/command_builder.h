#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/operations/command/operation_command.h"

namespace takt::operations {

/// The commands of a file as a tree of the command layer, and where in the file each of them is. Made when its step
/// is rehearsed or begins; the requests must outlive it. Realtime: setup.
class CommandBuilder {
 public:
  CommandBuilder(const OperationCommand& root, const BuildContext& build);

  [[nodiscard]] const command::Command& command() const { return parts_.front().made.command; }
  /// Commands in the order of the tree, each with the key of what it observes.
  struct Part {
    const OperationCommand* request;
    int parent;
    std::string key;  ///< "/screwing/insert"
    MadeCommand made;
    std::map<std::string, command::RaisedState, std::less<>> raised = {};
  };
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  /// The name under which a capture of a transaction is observed.
  [[nodiscard]] static std::string capture_name(const std::string& key, const std::string& capture) {
    return key + " captures " + capture;
  }

  /// Diagnostics of the command layer in the words of the file, with its pointers.
  [[nodiscard]] Diagnostics in_file(const Diagnostics& diagnostics) const;

 private:
  void add(const OperationCommand& request, int parent);
  void make(Part& part, BuildContext build);
  void set_up(Part& part);
  void set_cancel_policy(const Part& part);
  void add_handlers(const Part& part, const BuildContext& build);
  void add_captures(const Part& part, const BuildContext& build);
  [[nodiscard]] const Part& part_of(const OperationCommand& request) const;
  [[nodiscard]] const Part& named(const Part& from, const std::string& name) const;
  [[nodiscard]] command::RaisedState raised(const Part& from, const std::string& name) const;
  [[nodiscard]] command::Effect effect_of(const Part& owner, const HandlerParameters::Effect& effect,
                                          const BuildContext& build) const;
  [[nodiscard]] expression::State state_of(const Part& owner, const StateParameters& state,
                                           const BuildContext& build) const;
  [[nodiscard]] expression::State formula_of(const Part& owner, const StateParameters& state,
                                             const BuildContext& build) const;
  [[nodiscard]] expression::State action_state(const Part& owner, const StateParameters& state) const;

  std::vector<Part> parts_;
  std::map<const OperationCommand*, int> indices_;
  std::vector<std::pair<std::string, std::string>> places_;  ///< path in the tree, pointer in the file
};

}  // namespace takt::operations
