#include "languages/krl/type_table.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "languages/krl/lexer.h"

namespace takt::languages::krl {
namespace {

/// Elements of one array at most.
constexpr std::int64_t kMostInArray = 100'000;

}  // namespace

void TypeTable::error(const TextLocation& at, Code code, std::string message, std::string hint) {
  const Module& module = program_.modules[module_];
  error_at(diagnostics_, in_data_ ? module.data_file : module.file, at, code, std::move(message), std::move(hint));
}

void TypeTable::declare() {
  for (std::size_t m = 0; m < program_.modules.size(); ++m) {
    module_ = m;
    for (const TypeDeclaration& one : program_.modules[m].types) {
      auto& known = types_[m];
      if (known.contains(one.name)) {
        error(one.at, Code::kDuplicate, fmt::format("there are two types '{}'", one.name), "Rename one of them");
        continue;
      }
      if (one.is_enumeration) {
        program_.enumerations.push_back(std::make_unique<Enumeration>(Enumeration{one.name, one.constants}));
        known[one.name] = {Type::Kind::kEnum, nullptr, program_.enumerations.back().get()};
      } else {
        program_.structures.push_back(std::make_unique<Structure>(Structure{one.name, {}}));
        known[one.name] = {Type::Kind::kStructure, program_.structures.back().get(), nullptr};
      }
    }
  }
  // Those that all see come last, and others have them as parts.
  for (std::size_t m = program_.modules.size(); m > 0; --m) complete(m - 1);
}

/// A structure has structures that were declared before it: so none contains itself.
void TypeTable::complete(std::size_t m) {
  module_ = m;
  for (const TypeDeclaration& one : program_.modules[m].types) {
    if (one.is_enumeration) continue;
    auto* structure = const_cast<Structure*>(types_[m][one.name].structure);
    if (structure == nullptr || !structure->fields.empty()) continue;
    for (const Declaration& field : one.fields) {
      const Type type = find(field.type, field.at, static_cast<int>(m), true);
      if (type.structure != nullptr && type.structure->fields.empty()) {
        error(field.at, Code::kInvalidValue, fmt::format("'{}' is declared after '{}'", field.type, one.name),
              "Declare it before");
        continue;
      }
      structure->fields.push_back({field.name, type, sizes(field)});
    }
    std::int64_t left = kMostInArray;
    if ((void)make_value({Type::Kind::kStructure, structure, nullptr}, {}, left); left < 0) {
      error(one.at, Code::kTooLarge, fmt::format("'{}' has more than {} elements", one.name, kMostInArray),
            "Make it smaller");
      structure->fields.resize(1);
      structure->fields[0].size.clear();
      structure->fields[0].type = {Type::Kind::kReal, nullptr, nullptr};
    }
  }
}

Type TypeTable::find(const std::string& name, const TextLocation& at, int in, bool in_data) {
  module_ = static_cast<std::size_t>(in);
  in_data_ = in_data;
  constexpr std::array<std::pair<std::string_view, Type::Kind>, 4> kPlain{{{"BOOL", Type::Kind::kBool},
                                                                           {"INT", Type::Kind::kInt},
                                                                           {"REAL", Type::Kind::kReal},
                                                                           {"CHAR", Type::Kind::kChar}}};
  for (const auto& [word, kind] : kPlain)
    if (name == word) return {kind, nullptr, nullptr};
  const auto& own = types_[module_];
  if (const auto found = own.find(name); found != own.end()) return found->second;
  for (const auto& [module, types] : types_)
    if (const auto found = types.find(name); found != types.end()) return found->second;
  if (!name.empty()) {
    std::vector<std::string> names{"BOOL", "INT", "REAL", "CHAR"};
    for (const auto& [module, types] : types_)
      for (const auto& [known, type] : types) names.push_back(known);
    error(at, Code::kUnknownName, fmt::format("there is no type '{}'", name), nearest_choice(name, names));
  }
  return {};
}

std::vector<int> TypeTable::sizes(const Declaration& one) {
  std::vector<int> all;
  std::int64_t count = 1;
  for (const ExpressionPtr& size : one.size) {
    const bool known = size != nullptr && size->kind == Expression::Kind::kLiteral &&
                       size->value.kind == Value::Kind::kInt && size->value.integer > 0;
    const std::int64_t number = known ? size->value.integer : 1;
    if (!known && !(one.size.size() == 1 && size == nullptr))
      error(one.at, Code::kInvalidValue, fmt::format("the size of '{}' is no number above 0", one.name),
            "Write a whole number");
    count = std::min(count * number, kMostInArray + 1);
    all.push_back(static_cast<int>(std::min(number, kMostInArray + 1)));
  }
  if (count > kMostInArray || all.size() > 3) {
    error(one.at, Code::kTooLarge, fmt::format("'{}' is too large", one.name),
          fmt::format("Use at most 3 indices and {} elements", kMostInArray));
    all = {1};
  }
  return all;
}

}  // namespace takt::languages::krl
