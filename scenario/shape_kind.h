#pragma once

#include <string_view>
#include <vector>

#include "core/table/kinds.h"
#include "core/world/object.h"

namespace takt::scenario {

/// One kind of shape that an object can have: its sizes in files, and the parts that it is made of, about its own
/// frame. Defined in a file of its name and listed once in shape_kind.cc; a plug-in brings one with TAKT_SHAPE.
/// Realtime: setup.
using ShapeKind = table::Kind<std::vector<world::Object::Part>>;

/// A kind whose sizes are in a table of S, which has a function `parts()`.
template <class S, const table::Table<S>& (*table)()>
ShapeKind shape_kind(std::string_view name, std::string_view doc) {
  return {.name = name, .doc = doc, .keys = table::object_of<table>, .read = [](ObjectReader& reader) {
            S shape;
            table().read_into(shape, {reader});
            return shape.parts();
          }};
}

/// All kinds of the process. Ours are there from the beginning.
[[nodiscard]] table::Kinds<std::vector<world::Object::Part>>& shape_kinds();

/// Registers a kind of shape in a plug-in: a function without parameters that returns it.
///   TAKT_SHAPE(cone_shape);
#define TAKT_SHAPE(make)                                                                            \
  ::takt::table::KindRegistration<std::vector<::takt::world::Object::Part>> registration_of_##make( \
      ::takt::own_registrations, ::takt::scenario::shape_kinds(), make())

// -- What sizes of shapes have in common -----------------------------------------------------------------------------

/// Of a body that one can handle, m: contacts are stiff, and a thinner one would be jumped over in one step.
inline constexpr Range kBodySize{.low = 1e-5, .high = 1e3};

template <class S>
void add_size(table::Table<S>& table) {
  table.value("size_m", table::vector_type("m", kBodySize), &S::size, "Edge lengths x, y, z; of a container outside.")
      .required();
}
template <class S>
void add_radius(table::Table<S>& table) {
  table.number("radius_m", "m", &S::radius, kBodySize, "Radius; of a tube outside.").required();
}
template <class S>
void add_length(table::Table<S>& table) {
  table.number("length_m", "m", &S::length, kBodySize, "Length along z; of a capsule without its caps.").required();
}
template <class S>
void add_chamfer(table::Table<S>& table) {
  table.number("chamfer_m", "m", &S::chamfer, kNotNegative, "Width of the 45 degree chamfer at both ends.");
}
}  // namespace takt::scenario
