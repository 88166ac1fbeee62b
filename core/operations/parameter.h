#pragma once

#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/expression/cell.h"
#include "core/table/field.h"
#include "core/table/file_unit.h"

/// What the parameters of operations have in common, whatever their C++ types are (docs/operations.md). Realtime:
/// setup.
namespace takt::activity {

using table::NameOf;
/// One parameter as every form of an operation sees it: files, C++, schema, reference.
using ParameterInfo = table::Field;
using ParameterWriter = table::Writer;

/// All names of this kind, in order.
[[nodiscard]] std::vector<std::string> names_in(const command::Cell& cell, NameOf what);

/// The unit of the number at a JSON pointer below an operation, such as "/compliance/stiffness_N_m" or
/// "/to/position_m/2".
/// @return nothing if the parameters do not say: an unknown key, or the value of a device with a unit of its own
[[nodiscard]] std::optional<table::FileUnit> unit_at(std::span<const ParameterInfo> parameters,
                                                     std::string_view pointer);

/// What a table of parameters reads from.
struct ReadContext {
  ObjectReader& reader;
  const command::Cell& cell;
  /// Keys whose values a program has given in a form that files do not have, a state for instance.
  const std::set<std::string, std::less<>>* given = nullptr;

  /// The parameter was given, in a file or by a program.
  [[nodiscard]] bool has(std::string_view key) const {
    return reader.has(key) || (given != nullptr && given->contains(key));
  }
  /// The same for an object inside of the operation.
  [[nodiscard]] ReadContext inside(ObjectReader& part, const std::set<std::string, std::less<>>* keys = nullptr) const {
    return {part, cell, keys};
  }
};

}  // namespace takt::activity
