#pragma once

#include "languages/urscript/arguments.h"
#include "languages/urscript/poses.h"

/// The language of a controller's programs, by the names that it has here.
namespace takt::hw {

namespace urscript = languages::urscript;

namespace rtde {

using urscript::Arguments;
using urscript::BadArgument;
using urscript::checked;
using urscript::to_isometry;
using urscript::to_pose;
using urscript::to_value;

}  // namespace rtde
}  // namespace takt::hw
