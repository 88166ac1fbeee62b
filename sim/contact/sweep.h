#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// Small bodies that fly fast do not pass through what is thin: contacts are looked for where bodies are after a step,
/// and a nut of 5 mm that flies with 10 m/s goes 10 mm in it. A free body whose middle would be farther in one step
/// than its smallest radius, and beyond a surface on its straight way, is put back in front of that; the contact then
/// stops it. How the surface moves itself counts; two free bodies that fly towards each other are looked at against
/// where the other one was, moved on. Bodies with bores count as open. Owned by the world; one thread. Realtime: cyclic
/// but for the constructor.
class Sweep {
 public:
  Sweep() = default;
  /// @param open  by number of the geom: rays go through it
  Sweep(const mjModel_& model, std::vector<bool> open);

  /// Between the end of a step and the next look: positions are new, poses of bodies still those of its begin.
  void stop(const mjModel_& model, mjData_& data) const;

 private:
  struct Flyer {
    int body = 0, position = 0, velocity = 0;  ///< number of its root, addresses of its joint
    double radius = 0.0;                       ///< m: of the largest ball about its middle that is all within it, about
    Eigen::Vector3d p_BC = Eigen::Vector3d::Zero();  ///< m: the middle in the frame of its root
  };
  std::vector<Flyer> flyers_;
  std::vector<bool> open_;
};

}  // namespace takt::sim
