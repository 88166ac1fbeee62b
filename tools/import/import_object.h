#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/diagnostics.h"
#include "tools/import/convex_parts.h"
#include "tools/import/draft.h"

namespace takt::tools {

/// A thing without joints, from its mesh.
struct ObjectOptions {
  std::string name;            ///< of the model: lower case letters, digits, _
  std::filesystem::path mesh;  ///< .stl or .obj
  std::filesystem::path out;   ///< the folder of models that gets the folder `name`
  std::string title;           ///< for people; empty: the name
  double scale = 1.0;          ///< m of one unit of the file: 0.001 for millimetres
  std::optional<double> mass;  ///< kg; nothing: by the density
  double density = 1000.0;     ///< kg/m^3
  std::string material;        ///< of its surface; empty: what device files have without one
  SplitOptions split = {};
};

struct ObjectReport {
  std::filesystem::path folder;
  std::size_t parts = 0;  ///< convex ones
  double filled = 1.0;    ///< share of its convex hull
  double mass = 0.0;      ///< kg
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  std::vector<ImportNote> notes;
};

/// What is wrong with the options, all at once. Realtime: setup.
[[nodiscard]] Diagnostics check(const ObjectOptions& options);

/// Makes the folder out/name of kind object: URDF with the mesh as picture, convex parts as collision shapes, mass
/// properties of the solid; device file, README. Nothing is written unless all of it can be used as a model.
/// Realtime: setup.
[[nodiscard]] Result<ObjectReport> import_object(const ObjectOptions& options);

}  // namespace takt::tools
