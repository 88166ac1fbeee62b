#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/time.h"
#include "sim/contact/drive_law.h"
#include "sim/model/device.h"
#include "sim/model/solids.h"
#include "sim/model/world_description.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// What happened to a screw.
struct ThreadEvent {
  enum class Kind : std::uint8_t {
    kCaught,    ///< it entered a thread of its size, straight
    kCrossed,   ///< it entered it at an angle
    kSeated,    ///< its head has come to rest and the thread pulls
    kReleased,  ///< it has been turned out
  };
  Kind kind = Kind::kCaught;
  Nanoseconds time = 0;
  std::size_t screw = 0, bore = 0;  ///< numbers for ThreadLaw::name_of_screw and name_of_bore
};
[[nodiscard]] std::string_view name_of(ThreadEvent::Kind kind);

/// Screws and threaded bores. A screw is a free object until its tip stands in the mouth of a thread of its size,
/// nearly upright, and is turned to the right. Then the two are held together at their present pose, and one degree of
/// freedom is left: a turn about the axis of the bore, which goes with the pitch along it, against friction. Turned
/// back to where it was caught it is free again. A bolt is a screw that is fixed; then what has the bore, a nut, is
/// free and turns about it. Owned by the world; one thread. Equations and figures: docs/threads.md.
class ThreadLaw {
 public:
  ThreadLaw() = default;
  /// Realtime: setup.
  ThreadLaw(const mjModel_& model, const WorldDescription& description, const Solids& solids);
  [[nodiscard]] bool empty() const { return screws_.empty(); }

  /// As mj_step2, with the constraint of each screw in its thread. Realtime: cyclic.
  void finish_step(mjModel_& model, mjData_& data);
  /// Once per physics step, between its halves: sets the rows of the screws that are caught. Realtime: cyclic.
  void prepare(const mjModel_& model, mjData_& data);
  /// After the positions have changed: catches and releases.
  /// @return true: constraints and contacts of this state are others now, and must be made again. Realtime: cyclic.
  [[nodiscard]] bool watch(mjModel_& model, mjData_& data, Solids& solids, Nanoseconds now);
  /// After stream() has read another state. Realtime: setup.
  void resume(mjModel_& model, mjData_& data, Solids& solids);
  void stream(StateStream& state);

  /// All since the start, oldest first; those beyond a fixed number are dropped. Any thread. Realtime: cyclic.
  [[nodiscard]] std::span<const ThreadEvent> events() const;
  [[nodiscard]] std::vector<std::string> screw_names() const;
  [[nodiscard]] const std::string& name_of_screw(std::size_t screw) const { return screws_[screw].name; }
  [[nodiscard]] const std::string& name_of_bore(std::size_t bore) const { return bores_[bore].name; }
  /// What holds for a screw now: kReleased if it is free, kCrossed also once its head rests. Realtime: cyclic.
  [[nodiscard]] ThreadEvent::Kind state_of(std::size_t screw) const;
  /// Turns to the right since a screw was caught, rad; 0 if it is free. Realtime: cyclic.
  [[nodiscard]] double turned(std::size_t screw) const;

 private:
  static constexpr std::size_t kEvents = 256;
  /// What a body opposes to the rows of a constraint.
  struct Inertia {
    bool fixed = false;
    double mass = 0.0, rotation = 0.0;  ///< kg; kg m^2, the least
  };
  /// A threaded bore; B: its frame.
  struct ThreadedBore {
    std::string name, size;
    int body = 0, geom = 0;
    DrilledBore figures;
    Inertia inertia;
  };
  /// How a screw stands in its thread, as it was caught. All of it is state.
  struct Hold {
    std::int64_t bore = -1;  ///< -1: free
    bool crossed = false, seated = false;
    double angle = 0.0;   ///< rad, of the screw about the bore's axis, counted through whole turns
    double begin = 0.0;   ///< rad, the same when it was caught
    double height = 0.0;  ///< m, of the tip along the axis when it was caught
    Eigen::Vector2d off = Eigen::Vector2d::Zero();   ///< m, of the tip from the axis
    Eigen::Vector2d lean = Eigen::Vector2d::Zero();  ///< rad, about x and y of the bore
    double twist = 0.0;                              ///< rad, stretch of friction's spring
    double axial = 0.0;                              ///< N, of the thread on the screw along the axis in the last step
    double side = 0.0;                               ///< N, across the axis
    double pulled = 0.0;                             ///< s, for which it has pulled as at a seat
    std::int64_t mouth = -1;                         ///< of a free screw: the bore in whose mouth it turns; -1: none
    double begun = 0.0;                              ///< rad, to the right, that it has turned there
    double outside = 0.0;                            ///< s, since it was last seen in that mouth
  };
  struct Screw {
    std::string name;
    ThreadFigures thread;
    Pose X_OT = Pose::Identity();
    int body = 0, shank = 0, equality = 0;
    Inertia inertia;
    Hold hold;
  };
  struct RelativePose;

  [[nodiscard]] static Inertia inertia_of(const mjModel_& model, int body);

  [[nodiscard]] RelativePose stand_of(const mjModel_& model, const mjData_& data, const Screw& screw,
                                      const ThreadedBore& bore) const;
  [[nodiscard]] static bool in_mouth(const Screw& screw, const ThreadedBore& bore, const RelativePose& stand,
                                     bool entered);
  void take(std::size_t screw, std::size_t bore, const RelativePose& stand, Nanoseconds now);
  [[nodiscard]] bool rests(const mjModel_& model, const mjData_& data, const Screw& screw,
                           const ThreadedBore& bore) const;
  bool update_hold(const mjModel_& model, const mjData_& data, std::size_t index, Nanoseconds now);
  bool try_engage(const mjModel_& model, const mjData_& data, std::size_t index, Nanoseconds now);
  void apply(mjModel_& model, mjData_& data, Solids& solids, const Screw& screw) const;
  void set_rows(const mjModel_& model, mjData_& data, Screw& screw, int row);
  [[nodiscard]] double friction_limit(const Screw& screw) const;
  void remember_forces(const mjData_& data);
  void sense(const mjModel_& model, mjData_& data);
  [[nodiscard]] bool occupied(std::size_t bore) const;
  void report(ThreadEvent::Kind kind, std::size_t screw, std::size_t bore, Nanoseconds now);

  double timestep_ = 0.0;  ///< s, of this step
  std::vector<Screw> screws_;
  std::vector<ThreadedBore> bores_;
  DriveLaw drives_;
  std::vector<double> jacobians_;  ///< scratch: four of 3 x nv
  Eigen::RowVectorXd row_;         ///< scratch: nv
  std::vector<double> applied_;    ///< scratch: forces on bodies from outside
  std::array<ThreadEvent, kEvents> events_{};
  std::size_t event_count_ = 0;
};

}  // namespace takt::sim
