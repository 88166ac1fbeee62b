#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/base/registration.h"
#include "core/operations/table/parameter_table.h"

/// What a program can ask for by name: `lin`, `press`, `grip` (docs/operations.md). Realtime: setup.
namespace takt::operations {

class OperationCommand;
class Step;

/// An operation as it is written. All of it outlives the reading.
struct OperationSource {
  const nlohmann::ordered_json& json;
  const std::string& pointer;  ///< of `json` in its file
  const expression::Cell& cell;
  Diagnostics& diagnostics;
};

/// One kind of operation: what files, transactions, the reference and the schema know of it. Defined beside its
/// parameters, in the file of its name, and listed once in operation.cc; a plug-in brings one with TAKT_OPERATION.
struct Operation {
  std::string_view name;  ///< the step type: what "do" says
  std::string_view doc;   ///< what it does, one sentence
  const std::vector<ParameterInfo>& (*parameters)();
  /// Reads it as a step of a program. Null: it is one only inside of a transaction.
  std::unique_ptr<Step> (*read_step)(const OperationSource& source) = nullptr;
  /// Reads it as a command of a transaction. Null: it is no command.
  std::unique_ptr<OperationCommand> (*read_command)(const OperationSource& source) = nullptr;
  bool is_motion = false;  ///< a planned motion: it can be blended into the next one
};

/// All operations of the process, by name. Ours are there from the beginning.
class Operations {
 public:
  static Operations& global();
  /// A name that is in use is a programming error (abort); plug-ins ask first. Before other threads read it.
  void add(const Operation& operation);
  /// Null: there is none.
  [[nodiscard]] const Operation* find(std::string_view name) const;
  [[nodiscard]] const std::vector<Operation>& all() const { return operations_; }
  [[nodiscard]] std::vector<std::string> step_types() const;
  [[nodiscard]] std::vector<std::string> command_types() const;

 private:
  Operations();
  std::vector<Operation> operations_;
};

/// The unit of the number at a JSON pointer below an operation, commands of transactions included.
/// @param json  the operation as it is written; its key "do" says of which kind it is
/// @return nothing if its parameters do not say, see unit_at()
[[nodiscard]] std::optional<net::FileUnit> unit_in_operation(const nlohmann::ordered_json& json,
                                                             std::string_view pointer);

// -- What an operation is made of ------------------------------------------------------------------------------------

/// The rows of a table, whatever it fills.
template <auto table>
const std::vector<ParameterInfo>& rows_of() {
  return table().list();
}

/// The parameters, with diagnostics of all that is wrong with them.
template <auto table>
auto read_parameters(const OperationSource& source) {
  ObjectReader reader(source.json, source.pointer, source.diagnostics);
  return table().read(reader, source.cell);
}

/// A step that is made of the parameters.
template <class OwnStep, auto table>
std::unique_ptr<Step> read_step(const OperationSource& source) {
  return std::make_unique<OwnStep>(read_parameters<table>(source));
}

/// A command that is made of the parameters.
template <class OwnCommand, auto table>
std::unique_ptr<OperationCommand> read_command(const OperationSource& source) {
  return std::make_unique<OwnCommand>(read_parameters<table>(source));
}

/// The same, made by the function that programs in C++ use.
template <auto table, auto make>
std::unique_ptr<OperationCommand> make_command(const OperationSource& source) {
  return make(read_parameters<table>(source));
}

// -- Plug-ins --------------------------------------------------------------------------------------------------------

/// An operation of a plug-in, waiting for the loader.
class OperationRegistration final : public Registration {
 public:
  OperationRegistration(Registration*& list, const Operation& operation) : Registration(list), operation_(operation) {}

  [[nodiscard]] std::string_view what() const override { return "operation"; }
  [[nodiscard]] std::string_view name() const override { return operation_.name; }
  [[nodiscard]] Diagnostics check() const override;
  void add() override { Operations::global().add(operation_); }

 private:
  Operation operation_;
};

/// Registers an operation in a plug-in: a function without parameters that returns it.
///   TAKT_OPERATION(blow_operation);
#define TAKT_OPERATION(make) \
  ::takt::operations::OperationRegistration registration_of_##make(::takt::own_registrations, make())

}  // namespace takt::operations
