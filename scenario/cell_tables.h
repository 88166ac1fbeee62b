#pragma once

#include <string_view>

#include "core/table/table.h"
#include "record/compare.h"
#include "scenario/entries.h"

/// The tables of what a scenario file holds (docs/tables.md). Realtime: setup.
namespace takt::scenario {

/// A pose in a frame: "in", and the keys of a pose.
[[nodiscard]] const table::Table<Placement>& placement_table();
/// A pose in the frame of what it belongs to.
[[nodiscard]] const table::Table<Eigen::Isometry3d>& pose_table();
[[nodiscard]] const table::Table<FrameEntry>& frame_table();
[[nodiscard]] const table::Table<DeviceEntry>& device_entry_table();
[[nodiscard]] const table::Table<ObjectEntry>& object_table();
[[nodiscard]] const table::Table<CameraEntry>& camera_table();
[[nodiscard]] const table::Table<FilmEntry>& film_table();
[[nodiscard]] const table::Table<CollisionsEntry>& collisions_table();
[[nodiscard]] const table::Table<record::ToleranceRule>& tolerance_table();

/// A row for a surface's coefficient of friction, and one for its material.
template <class P>
void add_surface(table::Table<P>& table, std::string_view material_doc, std::string_view material_fallback) {
  table.named("material", table::NameOf::kMaterial, &P::material, material_doc)
      .fallback(material_fallback)
      .number("friction", "", &P::friction, kNotNegative,
              "Coefficient of sliding (Coulomb) friction of its surfaces instead of their material's. Of two surfaces "
              "the larger one counts.")
      .fallback("that of the material");
}

}  // namespace takt::scenario
