#include "cell/file/shape_kind.h"

#include "cell/file/shape_file.h"
#include "core/base/form_of.h"

namespace takt::cell {
namespace {

/// Of a body that one can handle, m: contacts are stiff, and a thinner one would be jumped over in one step.
constexpr Range kBodySize{.low = 1e-5, .high = 1e3};

const FormOf<world::Bore>& bore_form() {
  using world::Bore;
  static constexpr double kUntilKnown = 0.001;  // m, of a thread
  static const auto form =
      FormOf<Bore>("bore", "Its pose is that of the mouth in the frame of the shape, on a flat face.")
          .pose(&Bore::X_SB)
          .add(number_key("radius_m", "m", kPositive, "Radius of the wall.").optional("that of the thread"),
               [](FormReader& from, Bore& bore) { bore.radius = from.number("radius_m", kUntilKnown); })
          .add(text_key("thread", "Size of its thread, a name of models/threads.json: M3 to M8, M16 (docs/threads.md).")
                   .optional(),
               &Bore::thread)
          .add(text_key("clearance_for", "Size of the screw that goes through without touching.").optional(),
               [](FormReader& from, Bore& bore) {
                 if (const std::string size = from.text("clearance_for"); !size.empty())
                   bore.thread = kClearance + size;
               })
          .rule(exactly_one({"radius_m", "thread", "clearance_for"}))
          .add(number_key("depth_m", "m", kPositive, "Depth to the flat bottom.").optional("through the shape"),
               &Bore::depth)
          .add(number_key("chamfer_m", "m", kNotNegative, "Width of the 45 degree chamfer at each mouth.")
                   .optional("0, of a thread a little more than its depth"),
               [](FormReader& from, Bore& bore) {
                 bore.chamfer = from.number("chamfer_m", bore.thread.empty() ? 0.0 : -1.0);
               });
  return form;
}

}  // namespace

KindRegistry<ShapeKind>& ShapeKind::registry() {
  static KindRegistry<ShapeKind> kinds(
      {box_shape(), capsule_shape(), container_shape(), cylinder_shape(), gear_shape(), sphere_shape(), tube_shape()});
  return kinds;
}

Key edges_key(std::string doc) { return numbers_key("size_m", 3, "m", kBodySize, std::move(doc)); }
Key body_key(std::string name, std::string doc) { return number_key(std::move(name), "m", kBodySize, std::move(doc)); }
Key radius_key(std::string doc) { return body_key("radius_m", std::move(doc)); }
Key chamfer_key(std::string name, std::string doc) {
  return number_key(std::move(name), "m", kNotNegative, std::move(doc)).by_default(0.0);
}
Key bores_key() {
  return objects_key("bores", 0, bore_form().form(),
                     "Round holes. The frame of each is at its mouth, z out of the material (docs/bores.md).")
      .optional();
}

std::vector<world::Bore> read_bores(FormReader& from) {
  std::vector<world::Bore> bores;
  from.elements("bores", [&](const nlohmann::ordered_json& json, const std::string& pointer) {
    bores.push_back(bore_form().read(json, pointer, from.diagnostics()));
  });
  return bores;
}

}  // namespace takt::cell
