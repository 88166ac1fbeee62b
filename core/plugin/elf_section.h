#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt::plugin {

/// The bytes of a section of a shared object, read from the file without loading it, so that no code of it runs.
/// @return the bytes (empty if there is no such section); or why the file is no shared object of this machine: it does
/// not exist, is no ELF file, of another processor, cut off. Bounded: any bytes are safe. Realtime: setup.
[[nodiscard]] Result<std::string> read_elf_section(const std::filesystem::path& file, std::string_view section);

}  // namespace takt::plugin
