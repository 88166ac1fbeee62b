// Kind of shape "cage": bars around, on a circle, about z.
#include <cmath>
#include <numbers>

#include "cell/file/shape_kind.h"
#include "core/base/registration.h"

namespace fan {
namespace {

using namespace takt;

cell::ShapeKind cage() {
  return {"cage",
          {"Bars on a circle, along z.",
           {cell::radius_key("Radius of the circle."), cell::body_key("bar_radius_m", "Radius of a bar."),
            cell::body_key("length_m", "Length of the bars."),
            integer_key("bars", {.low = 1, .high = 100}, "How many.").by_default(8.0)}},
          [](FormReader& from) {
            const double radius = from.number("radius_m"), bar = from.number("bar_radius_m");
            const double length = from.number("length_m");
            const auto count = from.integer("bars");
            std::vector<world::Object::Part> parts;
            for (std::int64_t i = 0; i < count; ++i) {
              const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
              parts.push_back({.shape = world::Cylinder{bar, length}});
              parts.back().X_OS.translation() << radius * std::cos(angle), radius * std::sin(angle), 0.0;
            }
            return parts;
          }};
}

TAKT_SHAPE(cage);

}  // namespace
}  // namespace fan
