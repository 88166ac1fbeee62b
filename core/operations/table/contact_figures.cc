#include "core/operations/table/contact_figures.h"

#include <algorithm>

namespace takt::operations {
namespace {

/// From this share of the wanted force on there is contact, or from this force; below a third of that there is none any
/// more.
constexpr double kContactShare = 0.3, kContact_N = 2.0, kReleaseShare = 1.0 / 3.0;

/// From a force to when a net knows it, s.
double delay_of(const expression::Cell& cell, const std::string& sensor) {
  const auto found = cell.sensors.find(sensor);
  const bool known = found != cell.sensors.end() && found->second.device != nullptr;
  return known ? to_seconds(found->second.device->timing().sample_age) : 0.0;
}

}  // namespace

void set_contact_figures(command::ForceControlParameters& control, const expression::Cell& cell,
                         const std::string& sensor) {
  control.contact_force = std::min(kContactShare * control.force, kContact_N);
  control.release_share = kReleaseShare;
  control.sensor_delay = delay_of(cell, sensor);
}

}  // namespace takt::operations
