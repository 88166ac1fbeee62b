#pragma once

#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/table/operation.h"

/// "couple": locks a tool changer; what it has coupled is a tool of its arm from then on. "uncouple": unlocks it; the
/// tool stays where it is (docs/devices/tool-changer.md). Realtime: setup.
namespace takt::operations {

struct CoupleParameters {
  std::string changer = {};              ///< empty: the only one
  std::optional<std::string> tool = {};  ///< tool side, or a tool on it, that has to be there; nothing: any
  double timeout = 2.0;                  ///< s, until the lock is at its end
  std::string name = {}, pointer = {};   ///< for people; in its file
};
struct UncoupleParameters {
  std::string changer = {};              ///< empty: the only one
  std::optional<std::string> onto = {};  ///< frame or object that the tool depends on then; nothing: the world
  double timeout = 2.0;                  ///< s, until the lock is at its end
  std::string name = {}, pointer = {};   ///< for people; in its file
};
[[nodiscard]] const ParameterTable<CoupleParameters>& couple_parameters();
[[nodiscard]] const ParameterTable<UncoupleParameters>& uncouple_parameters();

[[nodiscard]] std::unique_ptr<OperationCommand> couple_command(const CoupleParameters& parameters);
[[nodiscard]] inline OperationForm<CoupleParameters> form_of(const CoupleParameters&) {
  return {"couple", couple_parameters, &CoupleParameters::changer, couple_command};
}
[[nodiscard]] std::unique_ptr<OperationCommand> uncouple_command(const UncoupleParameters& parameters);
[[nodiscard]] inline OperationForm<UncoupleParameters> form_of(const UncoupleParameters&) {
  return {"uncouple", uncouple_parameters, &UncoupleParameters::changer, uncouple_command};
}
[[nodiscard]] Operation couple_operation();
[[nodiscard]] Operation uncouple_operation();

}  // namespace takt::operations
