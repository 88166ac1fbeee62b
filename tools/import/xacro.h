#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"

namespace takt::tools {

/// What a xacro file is expanded with.
struct XacroOptions {
  std::vector<std::filesystem::path> packages;  ///< folders that hold packages, or are packages: for $(find NAME)
  std::vector<std::string> arguments;           ///< "NAME:=VALUE", for <xacro:arg>
};

/// The URDF that xacro makes of a file, in a process of its own with limits of time and memory. Expressions of the file
/// are evaluated by Python: a file from somebody who is not trusted may do harm.
/// @return diagnostics: what xacro says, or that it, Python or its YAML is not there. Realtime: setup.
[[nodiscard]] Result<std::string> expand_xacro(const std::filesystem::path& file, const XacroOptions& options);

}  // namespace takt::tools
