#pragma once

#include "languages/urscript/program.h"

/// Built-in functions that need nothing but their arguments.
namespace takt::languages::urscript {

/// Arithmetic, lists and strings.
void add_math_functions(Library& library);
/// Poses, rotations and wrenches.
void add_pose_functions(Library& library);

}  // namespace takt::languages::urscript
