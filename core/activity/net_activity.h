#pragma once

#include <memory>
#include <string>

#include "core/activity/activity_model.h"
#include "core/net/description.h"
#include "core/net/primitive.h"

namespace takt::activity {

/// A net that was written by hand, as an activity that begins at rest. Its actuators are the devices that it drives;
/// where it leaves arms is not known. Realtime: setup.
/// @param devices  with which it will be loaded; if LOAD will reject it there, its run says why
[[nodiscard]] ActivityPtr net_activity(const std::string& name, std::shared_ptr<const net::NetDescription> net,
                                       net::Environment& devices);

}  // namespace takt::activity
