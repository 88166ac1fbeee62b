#pragma once

#include <string>

#include "core/base/diagnostics.h"

struct mjSpec_;

namespace takt::sim {

/// A compiled specification as MuJoCo's XML, with all digits of its numbers. @return the text, or a diagnostic: MuJoCo
/// refuses, or this version of it writes six digits only. Thread: one at a time in the process. Realtime: setup.
[[nodiscard]] Result<std::string> mjcf_text(mjSpec_& spec);

}  // namespace takt::sim
