#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// Free objects that lie still, and what lies in or on them, fall asleep: MuJoCo leaves them out of a step until
/// something that moves touches them, a constraint joins them to it, or a force is applied. All that contacts join
/// falls asleep together, and only if all of it are free objects, or mobile bases that stand. Whether and when is
/// decided here and not by MuJoCo, which would solve that step once more without our contacts. Owned by the world; one
/// thread. Idea and figures: docs/simulation.md, "Parts at rest".
class Rest {
 public:
  Rest() = default;
  /// Sets what MuJoCo has to know; before its data are made. Realtime: setup.
  Rest(mjModel_& model, const WorldDescription& description);
  /// `device`, which lives as long as the world, drives all joints that move the body `root`: it says whether they
  /// stand. Realtime: setup.
  void add_driven(const mjModel_& model, int root, const SimDevice& device);

  /// After a step, while its contacts are still known: counts how long each object has been still.
  /// @return true: some are to fall asleep. Their velocity is zero now; after a look, fall_asleep() is to be called and
  /// the state looked at again. Realtime: cyclic.
  [[nodiscard]] bool settle(const mjModel_& model, mjData_& data);
  void fall_asleep(const mjModel_& model, mjData_& data);

  /// After the search for contacts: something that moves has met what sleeps. Kinematics and search are to be repeated;
  /// then they are awake. Realtime: cyclic.
  [[nodiscard]] bool wake_touched(const mjModel_& model, mjData_& data);
  /// After those kinematics: takes back what has told MuJoCo of it. Realtime: cyclic.
  void woken(mjData_& data);

  /// A force is applied to something that sleeps: the next look wakes it. Realtime: cyclic.
  [[nodiscard]] bool pushed(const mjModel_& model, const mjData_& data) const;

  /// The bodies sleep, or one does and the other is part of the cell. Realtime: cyclic.
  [[nodiscard]] static bool both_rest(const mjModel_& model, const mjData_& data, int body1, int body2);
  /// About the objects that settle() has found. Realtime: cyclic.
  [[nodiscard]] bool both_settle(const mjModel_& model, int body1, int body2) const;

  void stream(StateStream& state, mjData_& data);
  /// After stream() has read another state: all are awake, so that a look computes all of them; fall_asleep() follows.
  /// Realtime: setup.
  void wake_all(const mjModel_& model, mjData_& data);

 private:
  [[nodiscard]] bool still(const mjModel_& model, const mjData_& data, int tree) const;
  void count(const mjModel_& model, const mjData_& data);
  static void stop(const mjModel_& model, mjData_& data, int tree);
  [[nodiscard]] bool mark(const mjModel_& model, mjData_& data, int body);

  std::int64_t needed_ = 0;              ///< steps; 0: nothing sleeps here
  std::vector<std::int64_t> may_sleep_;  ///< by tree: 0 no, 1 yes
  std::vector<const SimDevice*> drive_;  ///< by tree: what moves it; null: nothing
  std::vector<std::int64_t> still_;      ///< by tree: steps for which it has been still
  std::vector<std::int64_t> next_;       ///< by tree: the next one that sleeps with it, as MuJoCo has it; -1: awake
  std::vector<bool> settling_;           ///< by tree
  std::vector<int> marked_;              ///< bodies
};

}  // namespace takt::sim
