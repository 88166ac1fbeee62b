#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

/// KRL: values, syntax, code and the machine that runs it (docs/krl.md). Nothing here knows a cell.
namespace takt::languages::krl {

struct Structure;

struct Enumeration {
  std::string name;
  std::vector<std::string> constants;
};

/// A type as a declaration names it; sizes of arrays stand beside it.
struct Type {
  enum class Kind : std::uint8_t { kUnknown, kBool, kInt, kReal, kChar, kEnum, kStructure };
  Kind kind = Kind::kUnknown;
  const Structure* structure = nullptr;
  const Enumeration* enumeration = nullptr;
  bool operator==(const Type&) const = default;
};

/// For people: "REAL", "E6POS".
[[nodiscard]] std::string to_string(const Type& type);

struct Field {
  std::string name;
  Type type;
  std::vector<int> size = {};  ///< of an array
};

struct Structure {
  std::string name;
  std::vector<Field> fields;
  /// -1: there is none.
  [[nodiscard]] int find(std::string_view field) const;
};

/// A value; kNothing: it was not given one yet. Numbers as KRL has them: mm, degrees.
struct Value {
  enum class Kind : std::uint8_t { kNothing, kBool, kInt, kReal, kText, kEnum, kStructure, kArray };
  Kind kind = Kind::kNothing;
  bool truth = false;
  std::int64_t integer = 0;
  double real = 0.0;
  std::string text;  ///< of a text, or the constant of an enumeration
  const Structure* structure = nullptr;
  std::vector<int> size;     ///< of an array, by dimension
  std::vector<Value> parts;  ///< fields of a structure, elements of an array, the last index fastest

  [[nodiscard]] bool nothing() const { return kind == Kind::kNothing; }
  [[nodiscard]] bool is_number() const { return kind == Kind::kInt || kind == Kind::kReal; }
  /// Of a number.
  [[nodiscard]] double number() const { return kind == Kind::kInt ? static_cast<double>(integer) : real; }
  /// The field of a structure that was given a number; else `fallback`.
  [[nodiscard]] double number_at(std::string_view field, double fallback) const;
  [[nodiscard]] bool has(std::string_view field) const;

  static Value of(bool truth);
  static Value of(std::int64_t integer);
  static Value of(double real);
  static Value constant(std::string name);
  static Value string(std::string text);
};

/// As a program writes it: TRUE, 3, 2.5, #RED, {X 1.0, Y 2.0}.
[[nodiscard]] std::string to_string(const Value& value);

/// A value of this type that was given nothing yet. @param left  elements that may still be made; negative afterwards:
/// too many
[[nodiscard]] Value make_value(const Type& type, const std::vector<int>& size, std::int64_t& left);

/// Converts as an assignment does: INT and REAL into each other (rounded), fields by their names. @return empty, or
/// what is wrong
[[nodiscard]] std::string assign(Value& target, const Type& type, const Value& value);

/// X, Y, Z in mm and A, B, C in degrees (about z, then the new y, then the new x) as a pose in m; what is not given
/// comes from `fallback`.
[[nodiscard]] Eigen::Isometry3d to_pose(const Value& frame, const Eigen::Isometry3d& fallback);
/// The same back, into the fields of a structure that has them.
void set_pose(Value& frame, const Eigen::Isometry3d& X);

}  // namespace takt::languages::krl
