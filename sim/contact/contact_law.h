#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sim/model/device.h"
#include "sim/model/solids.h"
#include "sim/model/world_description.h"

struct mjModel_;
struct mjData_;
struct mjContact_;

namespace takt::sim {

/// What two surfaces do to each other. Units: N/m, N s/m, 1, m, m.
struct ContactPair {
  double stiffness = 0.0;  ///< of the whole contact of two shapes, however many contact points it has
  double damping = 0.0;
  double friction = 0.0;  ///< sliding
  double torsion = 0.0;   ///< friction torque about the normal over friction force
  double rolling = 0.0;   ///< torque against rolling over normal force
};

/// Two surfaces touching: the springs of their materials act in series, the dampers dissipate together what each would
/// alone; a surface with a stiffness of its own gives that of the contact, of two such the softer. The larger friction
/// counts. A rule for the two materials replaces what neither surface gives by itself (docs/contacts.md, "Pairs").
/// Realtime: setup.
[[nodiscard]] ContactPair combine(const ContactParameters& a, const ContactParameters& b,
                                  std::span<const ContactRule> rules);

/// Gives each contact of the physics the stiffness, damping and friction of its pair of surfaces, in N/m and N s/m:
/// MuJoCo's own parameters scale with the masses in contact. Likewise the springs of joints. Remembers for each pair of
/// shapes in contact how far friction has been stretched, so that a part that is held neither creeps nor slips while it
/// is moved. Owned by the world. Realtime: cyclic, no allocation. Idea and equations: docs/contacts.md.
class ContactLaw {
 public:
  ContactLaw(const mjModel_& model, const WorldDescription& description);
  /// Once per physics step, between mj_step1 and mj_step2: replaces the rows of contacts and springs.
  void prepare(const mjModel_& model, mjData_& data, const Solids& solids);
  void stream(StateStream& state);
  /// How often since the start more pairs of shapes touched than are remembered: friction of those that are beyond it
  /// gives way like a damper. Realtime: cyclic.
  [[nodiscard]] std::int64_t forgotten() const { return forgotten_; }
  /// For how many pairs there is room.
  [[nodiscard]] std::size_t capacity() const { return before_.size(); }

 private:
  /// What is remembered of two shapes in contact.
  struct Memory {
    std::int64_t shapes = -1;                           ///< both numbers and the spring's; -1: free
    Eigen::Vector3d stretch = Eigen::Vector3d::Zero();  ///< m, of friction's spring, in the axes of the first body
    double twist = 0.0;                                 ///< rad, about the normal
    /// m, of the pressure, from the origin of each body in its axes.
    std::array<Eigen::Vector3d, 2> centre{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    Eigen::Vector3d roll = Eigen::Vector3d::Zero();  ///< rad, of the spring against rolling, likewise
    double shares = 0.0;                             ///< equally loaded points that the contact counts as
    double phase = 0.0;                              ///< rad, for how long they touch, in periods on their spring
  };
  struct Patch;
  struct Spring {
    int equality = 0;  ///< number of its constraint
    JointSpring figures;
    double mass = 0.0;  ///< kg or kg m^2 that moves against it, about
  };

  [[nodiscard]] const ContactPair& pair(int first, int second) const;
  [[nodiscard]] const Memory* remembered(std::int64_t shapes) const;
  void add_springs(const mjModel_& model, const WorldDescription& description);
  void set_springs(mjData_& data) const;
  void set_patch(const mjModel_& model, mjData_& data, const Solids& solids, int begin, int end);
  void set_along(Patch& patch, double stiffness, double damping) const;
  [[nodiscard]] bool lies_free(int body, int other) const;
  void set_rows(const mjModel_& model, mjData_& data, const Patch& patch, mjContact_& contact, double share) const;
  [[nodiscard]] double mobility(const mjModel_& model, const mjData_& data, const mjContact_& contact,
                                const Eigen::Vector2d& direction) const;
  void resist_rolling(const mjModel_& model, mjData_& data, const Patch& patch, const mjContact_& contact,
                      const Memory* old, Memory& memory) const;
  [[nodiscard]] std::pair<int, int> patches_from(const mjModel_& model, const mjData_& data, const Solids& solids,
                                                 int begin) const;
  void keep_resting(const mjModel_& model, const mjData_& data);
  void store(const Memory& memory);

  double timestep_ = 0.0;        ///< s, of this step
  int patches_of_pair_ = 1;      ///< of the two bodies that are looked at
  std::vector<int> surface_of_;  ///< of each geom, a number of a surface
  std::vector<bool> moved_;      ///< by number of the body: neither fixed to the world nor a part that is free
  std::size_t surfaces_ = 0;
  std::vector<ContactPair> pairs_;  ///< surfaces times surfaces
  std::vector<Spring> springs_;
  std::vector<double> loads_;  ///< scratch: N, of the points of a patch
  std::vector<Memory> before_, after_;
  std::size_t used_ = 0;  ///< of after_
  std::int64_t forgotten_ = 0;
};

}  // namespace takt::sim
