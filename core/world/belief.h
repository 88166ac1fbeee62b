#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"
#include "core/world/frame_graph.h"
#include "core/world/object.h"

namespace takt::world {

/// What is between the fingers of a gripper. F: flange of the arm that carries the gripper.
struct Hold {
  std::string object = {};                                 ///< empty: something that the application has no name for
  std::string arm = {};                                    ///< that carries the gripper
  Eigen::Isometry3d X_FO = Eigen::Isometry3d::Identity();  ///< the object in the flange, m
  Eigen::Vector3d p_FG = Eigen::Vector3d::Zero();          ///< where the fingers hold it, in the flange, m
  double mass = 0.0;                                       ///< kg, as the program said; 0: it said nothing
  // What the gripper reported when it had gripped; without a value in a rehearsal.
  std::optional<double> width = {}, force = {};  ///< m between the fingers; N, sum over them
  std::uint64_t command = 0;                     ///< number of the command that it answered
};

/// The machine on which something rides: its flange (of a base: its body), or another link of it.
struct Carrier {
  std::string arm;
  Eigen::Isometry3d X_FO = Eigen::Isometry3d::Identity();  ///< in that flange or link, m
  std::string link = {};                                   ///< empty: the flange
};

/// What the application believes of the world: where frames and objects are and what grippers hold. It begins as the
/// file says and changes by what steps do and measure. A copy of it is a branch: a rehearsal, an alternative, a plan.
/// The true world is the simulation's or the machine's; nothing here looks at it. Thread: the program's. Realtime:
/// setup.
struct Belief {
  FrameGraph frames;
  std::map<std::string, Object, std::less<>> objects;
  std::map<std::string, Hold, std::less<>> held;  ///< by gripper

  /// Where the frame is follows from something that is known or measured. False: it is lost, or depends on what is.
  [[nodiscard]] bool knows(std::string_view frame) const;
  /// The machine that the frame rides on, directly or through objects; of several the nearest one. Nothing: it stands.
  [[nodiscard]] std::optional<Carrier> carrier_of(std::string_view frame) const;
  /// A gripper holds the object, or what it lies on or in.
  [[nodiscard]] bool is_held(std::string_view object) const;
  /// The grippers that hold the object itself.
  [[nodiscard]] std::vector<std::string> holders_of(std::string_view object) const;
  /// Other objects that go where this frame goes: on it, in it, on those.
  [[nodiscard]] std::vector<std::string> riders(std::string_view frame) const;
  /// The object with all that rides on it, in its frame. Mass 0: no mass of it is known.
  [[nodiscard]] MassProperties mass_of(const std::string& object) const;
  /// What a gripper holds, in the flange of its arm. Each of several holders of one object bears its share where it
  /// holds it: the equilibrium in which no wrist bears a moment.
  [[nodiscard]] MassProperties load_in(const std::string& gripper) const;
  /// All that the grippers of an arm hold, in its flange.
  [[nodiscard]] MassProperties load_of(std::string_view arm) const;
  /// The object that a gripper would get hold of at this point: free, held by nobody, its surface the nearest one.
  /// @param within  m, to its surface   @return nothing: none is that near
  [[nodiscard]] std::optional<std::string> free_object_at(const Eigen::Vector3d& p_W, double within) const;
  /// What an object at X_WO would lie on or in: the object whose surface is nearest to a point of its lower half, at
  /// most `within` (m) away. Nothing: none is, as far as shapes tell.
  [[nodiscard]] std::optional<std::string> support_of(const std::string& object, const Eigen::Isometry3d& X_WO,
                                                      double within) const;

  /// A gripper has taken hold of something; what it held before is gone. The frame of the object rides on the flange
  /// from now on; of one that is held already it stays on that of its first holder.
  [[nodiscard]] Diagnostics take(const std::string& gripper, const Hold& hold);
  /// A gripper has opened. Its object stays at X_WO and depends on `onto` from now on, a frame; where another gripper
  /// holds it, on the flange of that one. @return what it held, or diagnostics: there is no frame `onto`
  Result<std::optional<Hold>> let_go(const std::string& gripper, const Eigen::Isometry3d& X_WO,
                                     const std::string& onto);
  /// The object has been found at X_WO, by a measurement. What it stands on, and who holds it, does not change.
  [[nodiscard]] Diagnostics found(const std::string& object, const Eigen::Isometry3d& X_WO);
  /// The frame that an object stands on, or in which it is believed to be: of one that is held, or lost, the world.
  [[nodiscard]] std::string standing_on(std::string_view object) const;
  /// Nobody knows where the object is any more. Grippers do not hold it.
  void lose(std::string_view object);
};

}  // namespace takt::world
