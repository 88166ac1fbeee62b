#pragma once

#include "core/program/language/expression.h"
#include "core/program/language/value.h"
#include "languages/script/data.h"

namespace takt::languages {

/// A value of a program for scripts: numbers in SI units, poses as {position_m, quaternion} in the world.
[[nodiscard]] Data to_data(const program::Value& value);
/// A value of a script for a variable of a program. Diagnostics without a pointer: it has no such form.
[[nodiscard]] program::Value to_value(const Data& data, const program::Type& wanted,
                                      const program::EvalContext& eval_context, Diagnostics& diagnostics);

}  // namespace takt::languages
