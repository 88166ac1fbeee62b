#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/base/form.h"
#include "core/device/device_file.h"

namespace takt::device {

/// A surface, and what two of them do together, as files have them.
[[nodiscard]] const Form& material_form();
[[nodiscard]] const Form& contact_rule_form();
/// The file materials.json.
[[nodiscard]] const Form& materials_form();

/// How the surface of a part answers a touch (docs/contacts.md).
struct Material {
  double stiffness = 0.0;  ///< N/m, of one side of a contact
  double damping = 0.0;    ///< N s/m, of one side
  double friction = 0.0;   ///< sliding, Coulomb
  double torsion = 0.0;    ///< m: torque about the normal over friction force
  double rolling = 0.0;    ///< m: torque against rolling over normal force
  double oiled = 0.15;     ///< friction with a film of oil between
};

/// What two materials do together; what is absent follows from the two.
struct MaterialRule {
  std::array<std::string, 2> between;
  std::optional<double> stiffness, damping, friction, oiled;  ///< N/m, N s/m, 1, 1
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

/// The file `materials.json` beside the models of the library, of each of its folders. Empty where there is no such
/// file; a name in two of them is a diagnostic. Realtime: setup.
[[nodiscard]] Result<MaterialTable> read_materials(const ModelLibrary& library);

}  // namespace takt::device
