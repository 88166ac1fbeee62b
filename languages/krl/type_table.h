#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "languages/krl/program.h"

namespace takt::languages::krl {

/// The types of all modules of a program, by module and name.
class TypeTable {
 public:
  TypeTable(Program& program, Diagnostics& diagnostics) : program_(program), diagnostics_(diagnostics) {}

  /// Makes the types that the modules declare.
  void declare();
  /// A type as it is seen in a module: of its own, or of any other. Unknown with a diagnostic.
  Type find(const std::string& name, const TextLocation& at, int module, bool in_data);
  /// The sizes of an array; empty: it is none.
  std::vector<int> sizes(const Declaration& one);

 private:
  void complete(std::size_t module);
  void error(const TextLocation& at, Code code, std::string message, std::string hint);

  Program& program_;
  Diagnostics& diagnostics_;
  std::map<std::size_t, std::map<std::string, Type, std::less<>>> types_;
  std::size_t module_ = 0;
  bool in_data_ = true;
};

}  // namespace takt::languages::krl
