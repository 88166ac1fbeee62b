#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "cell/file/net_files.h"
#include "cell/file/operator.h"
#include "cell/file/shape_file.h"
#include "cell/file/site.h"
#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/device/channel.h"
#include "core/world/object.h"
#include "record/compare.h"

namespace takt::cell {

/// A pose relative to a named frame: "in", "position_m", "rpy_deg" or "quaternion".
struct Placement {
  std::string in = "world";
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};

/// How far a placement is drawn from its nominal pose, from the scenario's seed and a name: uniformly, and normally.
struct Variation {
  double radius_m = 0.0;                                 ///< in a disc of this radius in the x-y plane of the frame
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< +- per axis
  Eigen::Vector3d rpy_deg = Eigen::Vector3d::Zero();     ///< +- per angle
  Eigen::Vector3d normal_m = Eigen::Vector3d::Zero();    ///< standard deviation per axis, beside what is uniform
};

struct FrameEntry {
  std::string name;
  Placement at;    ///< as it was drawn: the program knows it
  Variation vary;  ///< from which it was drawn
};

/// A device of the cell: what it is (model), where it stands (`at`) or on which device's flange it is mounted (`on`).
struct DeviceEntry {
  std::string name;
  std::string model;
  std::optional<Placement> at;
  std::string on;
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();  ///< with `on`: its base in the place that carries it, m
  Variation vary;                                           ///< of `mount`
  Eigen::Isometry3d true_mount = Eigen::Isometry3d::Identity();  ///< as it was drawn; the program does not know it
  std::vector<double> start_rad;  ///< joint positions at the start; empty = the model's home
  double payload_error_kg = 0.0;  ///< how much the controller believes more than there is
  std::string tool;      ///< of an arm: the device that is its tool where a step names none; empty: the only one
  std::string material;  ///< of its surfaces; empty: the model's
  std::optional<double> friction;  ///< of its surfaces, sliding, Coulomb; instead of the material's
  bool oiled = false;              ///< its surfaces
  std::string own_force;           ///< of an arm: name of the sensor that is made of its external torques; empty: none
  std::string tcp;  ///< of a tool: its tool centre point where a step names none; empty: that of its model
  std::map<std::string, Eigen::Isometry3d, std::less<>> tcps;  ///< more of them, in its mount frame, m
  bool may_fail = false;  ///< a fault of the scenario concerns its readings or its connection
  nlohmann::ordered_json settings = nlohmann::ordered_json::object();  ///< what the device's kind makes of it
};

/// Several devices under one name, to be held as a whole.
struct ComposedEntry {
  std::string name, pointer;
  std::vector<std::string> parts;  ///< devices, signals, or wholes that stand before
};

struct ObjectEntry {
  std::string name;
  std::string model;  ///< folder below models/, or empty if `parts` say the shape
  std::vector<world::Object::Part> parts;
  std::vector<std::string> part_pointers;  ///< one per part: where it is in the file
  std::optional<ScrewEntry> screw;         ///< instead of `parts`, until complete_threads()
  Placement at;
  Variation vary;
  bool fixed = true;
  double mass_kg = 1.0;                          ///< of a free object
  bool mass_given = false;                       ///< the file says it
  std::vector<double> part_masses_kg;            ///< one per part, or none: the mass is spread by volume
  std::optional<Eigen::Vector3d> centre_m;       ///< of mass, in the object's frame; instead of what the shapes give
  std::optional<Eigen::Matrix3d> inertia_kg_m2;  ///< about the centre of mass, axes of the object
  std::map<std::string, Eigen::Isometry3d, std::less<>> grasps;  ///< named frames in the object, m
  Eigen::Vector4d rgba{0.6, 0.6, 0.62, 1.0};
  std::string material;                                ///< of its surfaces; empty: the model's, or steel
  std::optional<double> friction;                      ///< sliding, Coulomb; instead of the material's
  bool oiled = false;                                  ///< its surface
  std::optional<double> stiffness_N_m, damping_N_s_m;  ///< of its contacts; instead of what materials give
  std::string lit_by;  ///< digital output or light barrier at which it burns; empty: it is no lamp
};

struct CameraEntry {
  std::string name;
  Placement at;  ///< looks along -z of this pose, y up, unless `look_at` is given
  std::optional<Placement> look_at;
  double fovy_deg = 45.0;
};

/// What the film shows beside the scene.
struct FilmShow {
  bool traces = true;      ///< paths of the tool centre points
  bool beams = true;       ///< of light barriers and range finders
  bool forces = true;      ///< of contacts of machines, as arrows
  bool commanded = false;  ///< machines where they are commanded to be, where they are not there
  bool frames = false;     ///< of the file, and the tool centre points
  double trace_s = 4.0;    ///< how long a path stays
};

/// The marks of a film by name: "traces", "beams", "forces", "commanded", "frames"; others are off. What is none of
/// them goes to `diagnostics`.
void choose_marks(const std::vector<std::string>& names, const std::string& pointer, FilmShow& show,
                  Diagnostics& diagnostics);

/// What the film shows: a camera from the beginning, others from the moment a named step begins, one as inset.
struct FilmEntry {
  struct Cut {
    std::string step, camera;
  };
  std::string camera;
  std::string inset;
  std::vector<Cut> cuts;
  std::string force_sensor;     ///< whose force is shown; empty = none
  double force_limit_N = 15.0;  ///< marked in the bar
  FilmShow show;
};

/// One statement that must hold at the end; `kind` chooses the fields, which cell/judge/expectations.cc reads.
struct ExpectationEntry {
  std::string name, kind, pointer;
  nlohmann::ordered_json json;
};

inline constexpr double kLongestRun = 3600.0;  ///< s, of simulated time

/// An entry of "faults": something that happens to the machines at one time, whatever the program does.
struct FaultEntry {
  static constexpr const char* kDefaultKind = "stop";

  Nanoseconds at = 0;
  std::string kind;
  std::string device;  ///< whose readings or connection are wrong: keys "sensor" and "device"; else empty
  std::string pointer;
  nlohmann::ordered_json json;
};

/// What the file says of collisions, in the rehearsal and in the run (docs/world.md).
struct CollisionsEntry {
  /// Two devices, objects or bodies ("arm/link_3") that may meet.
  struct Allowed {
    std::vector<std::string> between;
    std::string reason, pointer;
  };
  double margin_m = 1e-3;  ///< nearer than this counts as a collision
  std::string off;         ///< why nothing is checked; empty: it is
  std::vector<Allowed> allow;
};

/// A scenario file as read: checked for form, not yet against models.
struct Description {
  std::filesystem::path file;
  std::string text;  ///< the file with all overrides but the seed, nets from files put in, as JSON
  std::string title;
  std::uint64_t seed = 1;
  double time_limit_s = 120.0;
  std::int64_t program_latency_cycles = 2;
  double plant_mass_scale = 1.0;  ///< masses of the simulated arms against their URDF
  Nanoseconds physics_step = kMillisecond;
  std::vector<FrameEntry> frames;
  std::vector<DeviceEntry> devices;
  std::vector<ComposedEntry> composed;
  std::vector<ObjectEntry> objects;
  nlohmann::ordered_json materials = nlohmann::ordered_json::object();  ///< beyond those of the models folder
  nlohmann::ordered_json contacts = nlohmann::ordered_json::array();    ///< rules for pairs of materials
  std::vector<CameraEntry> cameras;
  FilmEntry film;
  std::vector<device::ChannelDescription> channels;
  std::vector<NetEntry> nets;
  nlohmann::ordered_json program;
  std::vector<FaultEntry> faults;                                      ///< in the order of their times
  nlohmann::ordered_json programs = nlohmann::ordered_json::object();  ///< what the program may call, by name
  std::vector<OperatorAction> operator_script;
  std::vector<ExpectationEntry> expectations;
  std::vector<record::ToleranceRule> tolerances;  ///< of its golden, and of comparisons of its recordings
  CollisionsEntry collisions;
  // Not of the file: where and how this run takes place.
  Site site;
  bool realtime = false;        ///< the wall clock goes on meanwhile: what costs too much is not admitted (row T5)
  std::filesystem::path image;  ///< gets a picture of the first collision of the rehearsal, or of the cell; empty: none
};

/// Replaces one value before the file is checked: `--set /devices/arm/model=NAME`.
struct Override {
  std::string pointer;
  std::string value;  ///< JSON; what is not JSON is taken as a text
};

/// Reads a scenario file. @return the description, or all diagnostics of form with file and JSON pointer.
[[nodiscard]] Result<Description> read_description(const std::filesystem::path& file,
                                                   const std::vector<Override>& overrides = {},
                                                   std::optional<std::uint64_t> seed = {});
[[nodiscard]] Result<Description> parse_description(std::string_view text, const std::vector<Override>& overrides = {},
                                                    std::optional<std::uint64_t> seed = {});

/// What a file is read for: with its program, or as the cell of a program in C++, where "program" may be missing.
enum class ReadFor { kScenario, kCell };

/// As far as the file can be read: what is wrong goes to `diagnostics`, with fallbacks in its place, so that more can
/// be checked. @return nothing if it is no JSON at all.
[[nodiscard]] std::optional<Description> read_description(const std::filesystem::path& file,
                                                          const std::vector<Override>& overrides,
                                                          std::optional<std::uint64_t> seed, Diagnostics& diagnostics,
                                                          ReadFor purpose = ReadFor::kScenario);

/// The pose of an object in its parent frame for a seed (row D5: same seed, same pose, whatever else is in the file).
[[nodiscard]] Eigen::Isometry3d drawn_pose(const ObjectEntry& object, std::uint64_t seed);
/// A pose that varies about X, for a seed and a name.
[[nodiscard]] Eigen::Isometry3d drawn_pose(const Eigen::Isometry3d& X, const Variation& vary, std::uint64_t seed,
                                           std::string_view name);

}  // namespace takt::cell
