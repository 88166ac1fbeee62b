#pragma once

#include <vector>

#include "core/table/table.h"
#include "core/world/bore.h"

namespace takt::scenario {

/// In Bore::thread before the name of a size, until the size is known: no thread, a hole for that screw.
inline constexpr const char* kClearance = "clearance ";

/// Round holes of objects in files (docs/bores.md). Realtime: setup.
[[nodiscard]] const table::Table<world::Bore>& bore_table();

/// The key "bores" of a shape that has a member of that name.
template <class S>
void add_bores(table::Table<S>& table) {
  table.elements("bores", "bore", bore_table(), &S::bores,
                 "Round holes in a box or cylinder. The frame of each is at its mouth, z out of the material "
                 "(docs/bores.md).");
}

}  // namespace takt::scenario
