#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/table/field.h"

namespace takt::table {

/// Prints tables as JSON Schema (draft-07). Definitions are collected as they are referred to. Realtime: setup.
class SchemaPrinter {
 public:
  using Json = nlohmann::ordered_json;

  /// Inside of a program any scalar may be an expression; the definition "expression" says what one is.
  enum class In { kFile, kProgram };
  explicit SchemaPrinter(In in = In::kFile);
  ~SchemaPrinter();
  SchemaPrinter(const SchemaPrinter&) = delete;
  SchemaPrinter& operator=(const SchemaPrinter&) = delete;

  /// The schema of a key: what it may hold, with its documentation.
  [[nodiscard]] Json of(const Field& field);
  /// An object with these keys and no others.
  [[nodiscard]] Json object_of(const Field& object);
  /// Prints a definition that nothing has referred to yet.
  void define(const Field& form);
  void define(const std::string& name, Json schema);
  /// Definitions that are not printed here, though they are referred to.
  void leave_out(std::vector<std::string> names) { left_out_ = std::move(names); }
  /// A part of the same schema with other rules for expressions; its definitions join those of this one.
  [[nodiscard]] Json in(In in, const Field& field);

  [[nodiscard]] const Json& definitions() const { return *definitions_; }

 private:
  [[nodiscard]] Json value_of(const Field& field);
  [[nodiscard]] Json refer_to(const Field& field);
  void add_variants(const Field& object, Json& properties, Json& all);
  [[nodiscard]] Json choose_kind(const Field& object);
  [[nodiscard]] Json body_of(const Field& field);
  [[nodiscard]] bool takes_expressions(const Field& field) const;

  In in_;
  std::vector<std::string> left_out_;
  std::unique_ptr<Json> definitions_;
};

/// {"$ref": "#/definitions/NAME"}
[[nodiscard]] nlohmann::ordered_json reference_to(std::string_view definition);
/// As people write it: 5, not 5.0.
[[nodiscard]] nlohmann::ordered_json plain_number(double value);
/// JSON of at most 120 columns a line; what fits on a line stays on one.
[[nodiscard]] std::string page_of(const nlohmann::ordered_json& json);

}  // namespace takt::table
