#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"

namespace takt::plugin {

/// A plug-in that is loaded.
struct Loaded {
  std::filesystem::path file;
  std::string name, version;
  std::vector<std::string> brings;  ///< "primitive Gain", "device kind fan", in the order of the alphabet
};

/// What a plug-in's section says that does not fit this program; empty if all fits. `text` may be any bytes.
[[nodiscard]] Diagnostics check_about(std::string_view text);

/// Loads a plug-in: reads what it was built with before any code of it runs, and adds its primitives and kinds of
/// device, all or none. It stays loaded until the process ends: nets and devices point into it.
/// @return it; or all that is wrong, with the file in the diagnostics: no such file, no shared object, no plug-in,
/// built for another takt or with other flags, symbols that are not there, names that are taken, declarations that are
/// broken. Realtime: setup; before other threads look at the registries.
[[nodiscard]] Result<Loaded> load(const std::filesystem::path& file);

}  // namespace takt::plugin
