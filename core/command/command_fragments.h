#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/command/mapping_context.h"

namespace takt::command {

class CommandSignals;

/// The fragments of the net: one for each command that carries out an action, with the source of its set points, its
/// end and the states that something asks for. A fragment is written when it is first asked for. Part of the mapping.
/// Realtime: setup.
class CommandFragments {
 public:
  /// @param commands  may not be constructed yet
  CommandFragments(MappingContext& context, CommandSignals& commands);

  /// The action has come to its end, or to rest after a cancel.
  [[nodiscard]] expression::Signal done(int i);
  /// A state or value of the action while its command is active.
  [[nodiscard]] expression::Signal state(int i, const expression::Expression& leaf);
  /// Some command gives the actuator nothing.
  [[nodiscard]] expression::Signal invalid(const std::string& actuator);
  /// Of a planned motion; else nothing.
  [[nodiscard]] std::optional<ClockPorts> clock(int i);
  void trace_set_point(int i);

 private:
  struct Entry {
    std::optional<expression::FragmentWriter> fragment;
    Contribution contribution;
    std::map<std::string, std::string> states;  ///< that are written, and their ports
  };
  [[nodiscard]] Entry& written(int i);

  MappingContext& context_;
  CommandSignals& commands_;
  std::vector<Entry> entries_;
};

}  // namespace takt::command
