#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "sim/film/render_scene.h"

/// What of a picture differs from the one before: while a camera stands, most of a cell does not move, and pixels are
/// what pictures cost (docs/film.md). Everything errs on the side of drawing too much. Realtime: setup.
namespace takt::sim {

using PixelBox = Eigen::AlignedBox2f;

/// Where a box in the world is in a picture. @param view  world to clip coordinates. @return pixels, or nothing: a part
/// of it lies beside or behind the eye
[[nodiscard]] std::optional<PixelBox> pixels_of(const Eigen::AlignedBox3f& box, const Eigen::Matrix4f& view, int width,
                                                int height);

/// The tiles of a picture that are drawn anew.
class TileMask {
 public:
  static constexpr int kSide = 32;  ///< pixels

  TileMask(int width, int height);
  void clear();
  void add_all();
  /// @param pixels  nothing: everywhere
  void add(const std::optional<PixelBox>& pixels);
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] bool whole() const { return count_ == marked_.size(); }
  /// Some of these pixels are in it. @param pixels  nothing: they may be anywhere
  [[nodiscard]] bool meets(const std::optional<PixelBox>& pixels) const;
  /// In pixels: left, top, width and height of the smallest rectangle around it.
  [[nodiscard]] std::array<int, 4> bounds() const;
  /// Rectangles that cover it and nothing else, in pixels: left, top, right, bottom.
  [[nodiscard]] std::vector<std::array<int, 4>> rectangles() const;

 private:
  struct Tiles {
    int left, top, right, bottom;  // the last two are not in it
  };
  [[nodiscard]] std::optional<Tiles> tiles_of(const PixelBox& pixels) const;

  int width_, height_, columns_, rows_;
  std::vector<std::uint8_t> marked_;  // by rows
  std::size_t count_ = 0;
};

/// The geoms of a scene as they were drawn; what came, went or changed since is found whatever their order.
class DrawnGeoms {
 public:
  struct Geom {
    SceneGeom::Look look;
    Eigen::AlignedBox3f box;
    bool casts_shadow, is_floor;
  };

  /// Takes over the geoms of `triangles` for which `wanted` holds.
  /// @return those that were not there before, and those that are not there any more
  template <class Wanted>
  [[nodiscard]] std::vector<Geom> replace(const SceneTriangles& triangles, const Wanted& wanted) {
    std::vector<Geom> geoms;
    for (const SceneGeom& geom : triangles.geoms)
      if (wanted(geom)) geoms.push_back({geom.look, geom.box, geom.casts_shadow && !geom.transparent, geom.is_floor});
    return replace(std::move(geoms));
  }

 private:
  [[nodiscard]] std::vector<Geom> replace(std::vector<Geom> geoms);

  std::vector<Geom> drawn_;  // in order of their looks
};

/// The light that casts shadows, for what a moved caster changes.
struct ShadowReach {
  std::optional<Eigen::Vector3f> direction;  ///< of a distant light; nothing: a lamp, whose shadows may be anywhere
  float lowest = 0;                          ///< z in the world below which nothing is lit, m
  float margin = 0;                          ///< by which a shadow may be wider than its caster, m
};

/// Marks what some geoms change in a picture, their shadows included.
/// @param reach  nothing: there are no shadows
void mark(const std::vector<DrawnGeoms::Geom>& changed, const Eigen::Matrix4f& view, int width, int height,
          const std::optional<ShadowReach>& reach, TileMask& mask);

}  // namespace takt::sim
