#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/channel.h"
#include "record/compare.h"
#include "scenario/entries.h"
#include "scenario/net_files.h"
#include "scenario/operator.h"
#include "scenario/site.h"

namespace takt::table {
template <class P>
class Table;
}

namespace takt::scenario {

class Fault;

/// One statement that must hold at the end; `kind` chooses the fields, which scenario/expectations.cc reads.
struct ExpectationEntry {
  std::string name, kind, pointer;
  nlohmann::ordered_json json;
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
  std::vector<std::shared_ptr<const Fault>> faults;                    ///< in the order of their times
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

/// What a scenario file holds, as one table (docs/tables.md). Realtime: setup.
[[nodiscard]] const table::Table<Description>& description_table();

/// The pose of an object in its parent frame for a seed (row D5: same seed, same pose, whatever else is in the file).
[[nodiscard]] Eigen::Isometry3d drawn_pose(const ObjectEntry& object, std::uint64_t seed);

}  // namespace takt::scenario
