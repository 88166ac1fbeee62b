#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/kind_registry.h"
#include "core/world/object.h"

namespace takt::cell {

/// A kind of shape: the word in "shape", its keys, and the bodies that it is made of, about its own frame. Ours and
/// those of plug-ins use the same way (docs/tables.md). Realtime: setup.
struct ShapeKind {
  static constexpr std::string_view kWhat = "shape";
  /// Ours are there from the beginning.
  static KindRegistry<ShapeKind>& registry();

  std::string name;
  Form form;
  std::function<std::vector<world::Object::Part>(FormReader&)> make;
};

/// Rows that several kinds have.
[[nodiscard]] Key edges_key(std::string doc);
[[nodiscard]] Key radius_key(std::string doc);
/// A size of a body that one can handle, m.
[[nodiscard]] Key body_key(std::string name, std::string doc);
[[nodiscard]] Key chamfer_key(std::string name, std::string doc);
[[nodiscard]] Key bores_key();
[[nodiscard]] std::vector<world::Bore> read_bores(FormReader& from);

/// The kinds that takt itself brings.
[[nodiscard]] ShapeKind box_shape();
[[nodiscard]] ShapeKind capsule_shape();
[[nodiscard]] ShapeKind container_shape();
[[nodiscard]] ShapeKind cylinder_shape();
[[nodiscard]] ShapeKind gear_shape();
[[nodiscard]] ShapeKind sphere_shape();
[[nodiscard]] ShapeKind tube_shape();

/// Registers a kind of shape in a plug-in: a function that returns a ShapeKind.
///   TAKT_SHAPE(cone_shape);
#define TAKT_SHAPE(function) \
  ::takt::KindRegistration<::takt::cell::ShapeKind> registration_of_##function(::takt::own_registrations, function())

}  // namespace takt::cell
