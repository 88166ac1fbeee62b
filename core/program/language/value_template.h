#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/net/file_unit.h"
#include "core/program/language/expression.h"

namespace takt::program {

/// A piece of a file in which texts may be expressions ("$height + 0.02[m]"). Immutable.
class ValueTemplate {
 public:
  ValueTemplate() = default;
  /// Diagnostics: expressions that are none, with their pointers.
  [[nodiscard]] static ValueTemplate parse(const nlohmann::ordered_json& json, const std::string& pointer,
                                           Diagnostics& diagnostics);

  /// There is no expression in it.
  [[nodiscard]] bool constant() const { return expressions_.empty(); }
  [[nodiscard]] const std::string& pointer() const { return pointer_; }
  /// It is worth something else while machines move: an expression reads them (Expression::changes), or it is a
  /// pose, or a list of poses, in a frame that moves.
  [[nodiscard]] bool changes(const expression::Cell& cell) const;
  /// A location at or below an expression, or one that holds it: what is wrong there shows only with its value.
  [[nodiscard]] bool depends(std::string_view pointer) const;
  /// Is there an expression below this key?
  [[nodiscard]] bool depends_on_key(std::string_view key) const;

  /// The unit of the number at a JSON pointer below the piece ("/compliance/stiffness_N_m"); nothing: any unit.
  using UnitOf = std::function<std::optional<net::FileUnit>(std::string_view pointer)>;

  /// The piece with all expressions replaced by their values, in the form that readers of files know. A number with a
  /// unit must have that of its key, and is converted to it.
  struct Resolved {
    std::shared_ptr<const nlohmann::ordered_json> json;
    std::vector<std::string> unknown;  ///< expressions that are not known yet; placeholders are in their place
  };
  /// @param cell  gets a frame for each pose at a key "in"
  [[nodiscard]] Resolved resolve(const EvalContext& eval_context, expression::Cell& cell, const UnitOf& unit_of,
                                 Diagnostics& diagnostics) const;

  /// The piece as one value: numbers, Booleans, texts, arrays as lists, goals {"in", "position_m", ...} as poses.
  [[nodiscard]] Value value(const EvalContext& eval_context, Diagnostics& diagnostics) const;

 private:
  class Resolver;
  std::shared_ptr<const nlohmann::ordered_json> json_;
  std::string pointer_;
  std::map<std::string, Expression> expressions_;  ///< by pointer
};

}  // namespace takt::program
