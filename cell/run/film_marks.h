#pragma once

#include <deque>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/file/description.h"
#include "cell/judge/contact_forces.h"
#include "sim/film/renderer.h"
#include "sim/model/marks.h"

namespace takt::cell {

/// Where the joints of the arms and bases are commanded to be, in the positions of the model.
class CommandedPositions {
 public:
  explicit CommandedPositions(const BuiltCell& built);

  /// Arms and bases with the joints that have a position in the model, in the order of their set points.
  struct Machine {
    std::string name;
    std::vector<std::string> joints;
    std::vector<int> addresses;  ///< in qpos; negative: none
    std::vector<bool> bodies;    ///< by number: its links
  };
  [[nodiscard]] const std::vector<Machine>& machines() const { return machines_; }

  /// `qpos` with the set points of machine i in it.
  static void put(const Machine& machine, std::span<const double> set_point, std::vector<double>& qpos);
  /// What was last sent.
  [[nodiscard]] std::vector<double> now(std::span<const double> qpos) const;
  /// The machines that are not where they are commanded to be: more than a degree or 10 mm away.
  [[nodiscard]] std::vector<bool> apart(std::span<const double> qpos, std::span<const double> commanded) const;

 private:
  const BuiltCell& built_;
  std::vector<Machine> machines_;
};

/// A state of the cell as marks need it.
struct MarkedState {
  Nanoseconds time = 0;
  std::span<const double> qpos;                 ///< of the model
  std::vector<double> commanded = {};           ///< the same with set points in it; empty: not known
  std::span<const ContactForce> contacts = {};  ///< since the state before
  std::vector<double> torches = {};             ///< in the order of FilmMarks::torch_signals(); not 0: its arc burns
};

/// What a film shows beside the scene: paths of the tool centre points, beams, forces, frames, commanded machines, and
/// the arcs and seams of torches. The
/// same from a run and from its recording: it poses the model by itself. Thread: one at a time. Realtime: setup.
class FilmMarks {
 public:
  /// The cell must outlive it.
  FilmMarks(const BuiltCell& built, const FilmShow& show);

  /// The digital inputs that say whether the arc of a torch burns.
  [[nodiscard]] const std::vector<std::string>& torch_signals() const { return torch_signals_; }

  /// The marks of a state; states come in the order of time.
  [[nodiscard]] sim::Marks at(const MarkedState& state);

  /// A camera that fits the cell as it is at `qpos`, for pictures of `aspect` (width / height).
  [[nodiscard]] sim::FreeCamera fitting_camera(std::span<const double> qpos, double aspect);

 private:
  struct Trace {
    int body = 0;
    Eigen::Isometry3d X_BT;
    std::array<float, 3> colour{};
    std::deque<std::pair<Nanoseconds, Eigen::Vector3d>> points = {};
  };
  struct Frame {
    int body = 0;
    Eigen::Isometry3d X_BF;
  };
  struct Beam {
    int body = 0;
    double range = 0.0;  ///< m
  };
  /// What a torch has left behind: beads in the axes of the body that they are on, each joined to the one before if
  /// the arc burned all the time.
  struct Torch {
    struct Bead {
      int body = 0;
      Eigen::Vector3d p_B;
      Nanoseconds time = 0;
      bool joined = false;
    };
    int body = 0;
    Eigen::Isometry3d X_BT;
    std::vector<Bead> beads = {};
    bool burned = false;
  };
  struct DataDeleter {
    void operator()(mjData_* data) const;
  };

  void pose(std::span<const double> qpos);
  [[nodiscard]] Eigen::Isometry3d body_pose(int body) const;
  void add_traces(Nanoseconds time, sim::Marks& marks);
  void add_beams(sim::Marks& marks) const;
  void add_frames(sim::Marks& marks) const;
  void add_seams(const MarkedState& state, sim::Marks& marks);
  void add_bead(Torch& torch, Nanoseconds time, sim::Marks& marks) const;

  FilmShow show_;
  const mjModel_& model_;
  std::unique_ptr<mjData_, DataDeleter> data_;
  CommandedPositions commanded_;
  std::vector<Trace> traces_;
  std::vector<Frame> frames_;
  std::vector<Beam> beams_;
  std::vector<Torch> torches_;
  std::vector<std::string> torch_signals_;
};

}  // namespace takt::cell
