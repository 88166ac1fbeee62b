#pragma once

#include <string>

#include "core/activity/context.h"

/// What becomes of parts that grippers hold, while a program runs. Realtime: setup.
namespace takt::activity {

/// Looks at each gripper that is believed to hold a part. It holds it no more when the gripper says so, when its
/// fingers stand elsewhere than where they gripped, or when they press no longer: then nobody knows where the part is,
/// and its arm is told to carry it no more. An event "lost" of the gripper says so. Called once a cycle, between
/// cycles, after steps that have ended have said what they did.
void notice_lost_parts(Context& context);

/// The same of each tool changer that is believed to have coupled a tool side, and says that it has not, while nothing
/// drives its lock.
void notice_lost_tools(Context& context);

}  // namespace takt::activity
