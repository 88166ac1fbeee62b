#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/net/unit.h"

namespace takt::program {

/// What a variable of a program can hold. Types are known before anything runs; kUnknown fits everything (an element
/// of a list of which nothing is known yet).
struct Type {
  enum class Kind { kUnknown, kBoolean, kNumber, kText, kPose, kList };
  Kind kind = Kind::kUnknown;
  net::Dimension unit;        ///< of a number
  std::vector<Type> element;  ///< of a list: one

  bool operator==(const Type&) const = default;
  [[nodiscard]] bool is(Kind wanted) const { return kind == wanted || kind == Kind::kUnknown; }

  static Type boolean() { return {Kind::kBoolean, {}, {}}; }
  static Type number(const net::Dimension& unit = {}) { return {Kind::kNumber, unit, {}}; }
  static Type text() { return {Kind::kText, {}, {}}; }
  static Type pose() { return {Kind::kPose, {}, {}}; }
  static Type list_of(Type element) { return {Kind::kList, {}, {std::move(element)}}; }
};

/// The dimension of a unit such as "N/m"; none of a malformed one.
[[nodiscard]] net::Dimension unit_dimension(std::string_view unit);

/// "number in m", "list of pose", ... for people.
[[nodiscard]] std::string to_string(const Type& type);
/// True if a variable of type `wanted` may take a value of type `given`. A number without a unit takes that of its
/// key, as numbers in files do.
[[nodiscard]] bool accepts(const Type& wanted, const Type& given);
/// The type that fits both; kUnknown where none does.
[[nodiscard]] Type common(const Type& a, const Type& b);
/// {"type": "number", "unit": "m"} and the like, read and written. Keys that are not of the type are left to the
/// caller.
[[nodiscard]] std::optional<Type> type_from_text(std::string_view text, std::string_view unit);

/// A value with its type; null: it is not known (yet). Everything but null has a payload of its type's kind.
struct Value {
  Type type;
  std::variant<std::monostate, bool, double, std::string, Eigen::Isometry3d, std::vector<Value>> data;

  [[nodiscard]] bool null() const { return data.index() == 0; }
  [[nodiscard]] bool boolean() const { return std::get<bool>(data); }
  [[nodiscard]] double number() const { return std::get<double>(data); }
  [[nodiscard]] const std::string& text() const { return std::get<std::string>(data); }
  [[nodiscard]] const Eigen::Isometry3d& pose() const { return std::get<Eigen::Isometry3d>(data); }
  [[nodiscard]] const std::vector<Value>& list() const { return std::get<std::vector<Value>>(data); }

  static Value unknown(Type type) { return {std::move(type), {}}; }
  static Value of(bool value) { return {Type::boolean(), value}; }
  static Value of(double value, const net::Dimension& unit = {}) { return {Type::number(unit), value}; }
  static Value of(std::string value) { return {Type::text(), std::move(value)}; }
  static Value of(const Eigen::Isometry3d& X_WP) { return {Type::pose(), X_WP}; }
  static Value of(std::vector<Value> values);
};

/// For logs: "3", "0.25 m", "true", "(0.1, 0, 0.3) m", "unknown".
[[nodiscard]] std::string to_string(const Value& value);
/// The same with all digits and its type, and back. from_json() throws nlohmann's exceptions on a foreign form.
[[nodiscard]] nlohmann::ordered_json to_json(const Value& value);
[[nodiscard]] Value value_from_json(const nlohmann::ordered_json& json);
/// A pose as the keys that files have for it: position_m, quaternion.
[[nodiscard]] nlohmann::ordered_json pose_to_json(const Eigen::Isometry3d& X);
[[nodiscard]] Eigen::Isometry3d pose_from_json(const nlohmann::ordered_json& json);

/// A variable of a program. Its type never changes.
struct Variable {
  Type type;
  Value value;
  std::optional<Value> nominal;  ///< what a rehearsal takes it to be while it is not known
};

/// The variables of a part of a program, inside those of the part around it. A sub-program sees nothing around it.
class Scope {
 public:
  explicit Scope(Scope* around = nullptr) : parent_(around) {}

  /// Makes a variable, or replaces the one of this name in this very scope.
  void declare(const std::string& name, Variable variable) { own_[name] = std::move(variable); }
  [[nodiscard]] Variable* find(std::string_view name);
  [[nodiscard]] const Variable* find(std::string_view name) const { return const_cast<Scope*>(this)->find(name); }
  [[nodiscard]] std::vector<std::string> names() const;
  /// A number without a unit becomes one of the variable's; what is not known takes the nominal value if `rehearsing`.
  void assign(Variable& variable, Value value, bool rehearsing);

  /// The values of this scope and of all around it, to be put back.
  using Saved = std::vector<std::map<std::string, Variable, std::less<>>>;
  [[nodiscard]] Saved save() const;
  void restore(const Saved& saved);
  /// The values of this scope alone.
  [[nodiscard]] nlohmann::ordered_json to_json() const;
  void from_json(const nlohmann::ordered_json& json);

 private:
  Scope* parent_;
  std::map<std::string, Variable, std::less<>> own_;
};

/// True for a letter followed by letters, digits and underscores that is no word of the language.
[[nodiscard]] bool is_variable_name(std::string_view name);

}  // namespace takt::program
