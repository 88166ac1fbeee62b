#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "cell/file/shape_kind.h"

namespace takt::cell {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Part = world::Object::Part;

// ISO 53: pressure angle, addendum and dedendum in modules.
constexpr double kPressureAngle = 20.0 * std::numbers::pi / 180.0;
constexpr double kAddendum = 1.0, kDedendum = 1.25;
// A flat flank goes through the involute here and at the tip, in modules below the pitch circle.
constexpr double kInner = 0.8;
constexpr double kInRim = 0.3;   // modules by which a tooth reaches into the rim
constexpr double kInHub = 0.98;  // of the hub's radius: rim and hub overlap

double involute(double angle) { return std::tan(angle) - angle; }

/// One flank of a tooth in its plane: x along the middle of the tooth, y across it, m.
struct Flank {
  Vector2d tip, out;  ///< where it ends; unit vector along it, outwards
};

/// A point of the involute flank at a radius; below the base circle straight inwards.
Vector2d flank_point(double module, int teeth, double radius) {
  const double pitch = 0.5 * module * teeth, base = pitch * std::cos(kPressureAngle);
  const double half = 0.5 * std::numbers::pi / teeth + involute(kPressureAngle) -
                      (radius > base ? involute(std::acos(base / radius)) : 0.0);
  return radius * Vector2d(std::cos(half), std::sin(half));
}

/// The straight line nearest to the involute: off by the same amount in the middle as at both ends.
Flank flat_flank(double module, int teeth) {
  const double pitch = 0.5 * module * teeth;
  const double inner = pitch - kInner * module, outer = pitch + kAddendum * module;
  const Vector2d foot = flank_point(module, teeth, inner), end = flank_point(module, teeth, outer);
  const Vector2d out = (end - foot).normalized(), side(-out.y(), out.x());
  double bulge = 0.0;
  for (int i = 1; i < 20; ++i)
    bulge = std::max(bulge, side.dot(flank_point(module, teeth, inner + 0.05 * i * (outer - inner)) - foot));
  // The tip lies on the shifted line and on the tip circle.
  const Vector2d on_line = foot + 0.5 * bulge * side;
  const double along = on_line.dot(out);
  const double reach = std::sqrt(along * along + outer * outer - on_line.squaredNorm()) - along;
  return {on_line + reach * out, out};
}

/// Two boxes, one along each flank, which cross at the tip.
void add_tooth(std::vector<Part>& parts, const Flank& flank, double root, double width, double angle) {
  const double length = (flank.tip.x() - root) / flank.out.x();
  const double thick = 2.0 * flank.tip.y() / flank.out.x();
  const Vector2d in(flank.out.y(), -flank.out.x());
  const Vector2d middle = flank.tip - 0.5 * length * flank.out + 0.5 * thick * in;
  for (const double side : {1.0, -1.0}) {
    Part part{.shape = world::Box{Vector3d(length, thick, width)}};
    const double lean = std::atan2(flank.out.y(), flank.out.x());
    const Eigen::AngleAxisd turn(angle, Vector3d::UnitZ());
    part.X_OS.translation() = turn * Vector3d(middle.x(), side * middle.y(), 0.0);
    part.X_OS.linear() = (turn * Eigen::AngleAxisd(side * lean, Vector3d::UnitZ())).toRotationMatrix();
    parts.push_back(std::move(part));
  }
}

Part bored_cylinder(double radius, double length, double bore_radius, double chamfer) {
  Part part{.shape = world::Cylinder{radius, length}};
  world::Bore bore;
  bore.radius = bore_radius;
  bore.chamfer = chamfer;
  bore.X_SB.translation().z() = 0.5 * length;
  part.bores.push_back(std::move(bore));
  return part;
}

std::vector<Part> make_gear(FormReader& from) {
  const double module = from.number("module_m"), width = from.number("width_m"), bore = from.number("bore_radius_m");
  const int teeth = static_cast<int>(from.integer("teeth"));
  const double chamfer = from.number("bore_chamfer_m");
  const double hub = from.number("hub_radius_m", 0.0), hub_length = from.number("hub_length_m", 0.0);
  const double root = module * (0.5 * teeth - kDedendum);
  const auto refuse = [&](const char* key, double value, std::string hint) {
    from.diagnostics().error(Code::kOutOfRange, from.at(key),
                             fmt::format("{:g} m in a gear of root radius {:g} m", value, root), std::move(hint));
  };
  if (bore + chamfer >= root)
    refuse("bore_radius_m", bore, "Make the bore and its chamfer smaller than the root of the teeth");
  if (hub > 0.0 && (hub >= root || kInHub * hub <= bore + chamfer))
    refuse("hub_radius_m", hub, "Keep the hub between the bore with its chamfer and the root of the teeth");
  std::vector<Part> parts;
  if (hub > 0.0) {
    parts.push_back(bored_cylinder(hub, width + hub_length, bore, chamfer));
    parts.back().X_OS.translation().z() = 0.5 * hub_length;
    parts.push_back(bored_cylinder(root, width, kInHub * hub, 0.0));
  } else {
    parts.push_back(bored_cylinder(root, width, bore, chamfer));
  }
  const Flank flank = flat_flank(module, teeth);
  for (int i = 0; i < teeth; ++i)
    add_tooth(parts, flank, root - kInRim * module, width, 2.0 * std::numbers::pi * i / teeth);
  return parts;
}

}  // namespace

ShapeKind gear_shape() {
  return {
      "gear",
      {"A spur gear about z (ISO 53, pressure angle 20 degrees), its frame in the middle of the teeth, one tooth at "
       "x. Its flanks are flat: what an involute is next to (docs/gears.md).",
       {body_key("module_m", "Module: pitch diameter over number of teeth."),
        integer_key("teeth", {.low = 12, .high = 200}, "Number of teeth."),
        body_key("width_m", "Length of the teeth along z."), body_key("bore_radius_m", "Radius of its bore."),
        chamfer_key("bore_chamfer_m", "Width of the 45 degree chamfer at both ends of the bore."),
        body_key("hub_radius_m", "Radius of a hub on the side of z.").optional("no hub"),
        number_key("hub_length_m", "m", kNotNegative, "Length of the hub beyond the teeth.").by_default(0.0)}},
      make_gear};
}

}  // namespace takt::cell
