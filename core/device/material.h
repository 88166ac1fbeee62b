#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/device/device_file.h"
#include "core/table/field.h"

namespace takt::device {

/// How the surface of a part answers a touch (docs/contacts.md).
struct Material {
  double stiffness = 0.0;  ///< N/m, of one side of a contact
  double damping = 0.0;    ///< N s/m, of one side
  double friction = 0.0;   ///< sliding, Coulomb
  double torsion = 0.0;    ///< m: torque about the normal over friction force
  double rolling = 0.0;    ///< m: likewise, against rolling
};

/// What two materials do together; what is absent follows from the two.
struct MaterialRule {
  std::array<std::string, 2> between;
  std::optional<double> stiffness, damping, friction;  ///< N/m, N s/m, 1
};

/// Materials by name, and the pairs that are known better than by their materials.
struct MaterialTable {
  std::map<std::string, Material> materials;
  std::vector<MaterialRule> rules;  ///< a later one for the same pair counts

  /// Adds the members "materials" and "contacts" of an object; names that exist are replaced. Diagnostics: wrong
  /// types and ranges, unknown keys, unknown materials in "like" and "between". Realtime: setup.
  /// @param materials, contacts  may be null
  void read(const nlohmann::ordered_json* materials, const nlohmann::ordered_json* contacts, const std::string& pointer,
            Diagnostics& diagnostics);
  /// @return null if there is none; with a diagnostic at `pointer` that names the nearest
  [[nodiscard]] const Material* find(const std::string& name, const std::string& pointer,
                                     Diagnostics& diagnostics) const;
};

/// The members "materials" and "contacts" of an object, as data.
[[nodiscard]] table::Field materials_field();
[[nodiscard]] table::Field contacts_field();

/// The file `materials.json` beside the models of the library, of each of its folders. Empty where there is no such
/// file; a name in two of them is a diagnostic. Realtime: setup.
[[nodiscard]] Result<MaterialTable> read_materials(const ModelLibrary& library);

}  // namespace takt::device
