#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"
#include "tools/import/mesh_files.h"

namespace takt::tools {

/// A surface of triangles, counter-clockwise seen from outside; corners that coincide are one point.
struct Triangles {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> faces;  ///< indices into points

  /// Each edge belongs to two triangles that run along it in opposite directions: the surface encloses a solid.
  [[nodiscard]] bool closed() const;
};

/// What a mesh file holds, in its unit. @return a diagnostic: a corner that is not there.
[[nodiscard]] Result<Triangles> triangles_of(const MeshFile& mesh);

/// The text of a Wavefront OBJ. @param scale  factor on all lengths
[[nodiscard]] std::string obj_of(const Triangles& mesh, double scale = 1.0);

/// Of the solid inside a closed surface, of density 1. Source: the divergence theorem over tetrahedra from the origin.
struct SolidFigures {
  double volume = 0.0;                                ///< m^3; negative: the triangles are turned inside out
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< of mass, m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre, kg m^2 at 1 kg/m^3
};
[[nodiscard]] SolidFigures solid_figures(const Triangles& mesh);

}  // namespace takt::tools
