#pragma once

#include <filesystem>
#include <memory>

#include "core/net/compiled_net.h"

namespace takt::tools {

/// Reads, verifies and compiles a net file. @return the net, or all diagnostics with the file in them.
[[nodiscard]] Result<std::unique_ptr<net::CompiledNet>> load_net_file(const std::filesystem::path& file,
                                                                      net::Environment& devices);

}  // namespace takt::tools
