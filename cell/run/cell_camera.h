#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cell/build/built_cell.h"

namespace takt::cell {

/// What a state of the cell was, as far as pictures show it.
struct PictureState {
  std::vector<double> positions;  ///< sim::World::positions()
  std::vector<double> lamps;      ///< of sim::World::data(): its userdata
};

/// Copies the state of a world at this moment, on the thread that steps it. Realtime: cyclic, once it has been called.
void copy_picture_state(const sim::World& world, PictureState& state);

/// Draws what cameras of a cell see, as PNG. It lives on one thread, which need not be that of the cycle: it has a
/// state and a graphics context of its own. Realtime: setup.
class CellCamera {
 public:
  static constexpr int kLeast = 16, kMostWidth = 1920, kMostHeight = 1080;  ///< pixels
  /// The name of the free camera that shows everything, unless the cell has one of that name.
  static constexpr std::string_view kOverview = "overview";

  /// How much work a picture is.
  enum class Quality {
    kFilm,  ///< shadows and smooth edges
    kLive   ///< without both, and packed less well: for pictures that are looked at once
  };
  /// @return diagnostics: no graphics
  [[nodiscard]] static Result<std::unique_ptr<CellCamera>> open(const BuiltCell& built,
                                                                Quality quality = Quality::kFilm);
  ~CellCamera();
  CellCamera(const CellCamera&) = delete;
  CellCamera& operator=(const CellCamera&) = delete;

  /// @return the bytes of a PNG file; diagnostics: an unknown camera, a size that is not possible
  [[nodiscard]] Result<std::string> picture(std::string_view camera, int width, int height, const PictureState& state);

 private:
  struct Impl;
  explicit CellCamera(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::cell
