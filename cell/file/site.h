#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/form_of.h"
#include "core/device/driver.h"
#include "core/emulation/slow_options.h"

namespace takt::cell {

/// A way to reach a device: what "backend" in a site file and KIND of --backend may say.
struct BackendKind {
  std::string name;
  bool own_clock = false;  ///< the device has a clock that is no simulation's: forces real time (row T4)
  std::string doc;
};

/// The kinds there are, those of drivers that are known (device::DriverKinds) included. Realtime: setup.
[[nodiscard]] std::vector<BackendKind> backend_kinds();

/// The kind of an I/O block whose terminals are those of an arm's controller: `of` says which arm.
inline constexpr const char* kTerminals = "terminals";

/// How one device of the cell is reached.
struct Binding {
  std::string kind = "sim";
  /// Of kind "slow"; a cycle of 0 stands for that of the model.
  emulation::SlowOptions slow = {};
  /// Of kind "terminals": the arm whose controller has them.
  std::string of = {};
  /// Of a kind with a driver, else null.
  std::shared_ptr<const device::DriverSettings> driver;
  std::string file, pointer;  ///< where it was said

  /// Reached over a real wire: the device keeps the machine's time (row T4).
  [[nodiscard]] bool own_clock() const { return driver && !driver->in_process(); }
};

/// Share of the planned speed at which hardware moves unless the site says otherwise.
inline constexpr double kFirstSpeed = 0.25;

/// Arms, by their names.
using ArmSet = std::set<std::string, std::less<>>;
/// Arms that one net drives together.
using ArmGroups = std::set<ArmSet>;
/// Groups that share an arm as one: none of them shares one with another.
[[nodiscard]] std::vector<ArmSet> merged(const ArmGroups& groups);

/// What is true of one place and not of the scenario: which back end each device has (docs/sites.md). Devices that are
/// not named are simulated.
struct Site {
  std::map<std::string, Binding, std::less<>> devices;
  std::string text = {};  ///< of the file; empty: there is none
  std::string file = {};  ///< its name; empty: there is none
  /// Arms that cooperate are made as late as the slowest of them, so that they are together at their flanges (row T3).
  bool pad_delays = true;
  /// The arm whose controller's clock paces the core, in real time; empty: the machine's clock does.
  std::string master_clock = {};
  /// Share of the planned speed with which a run begins. Null: all of it, but kFirstSpeed where hardware moves.
  std::optional<double> speed_override = std::nullopt;
  /// Which arms cooperate: sets of names, in any overlap. Null: it is not known, and all do.
  std::optional<ArmGroups> cooperating = std::nullopt;
  /// Groups of arms, without a common one, of which no net may drive two: it is rejected.
  std::vector<ArmSet> separate = {};
  /// False: drivers are left out, and their arms simulated. Their delays count all the same.
  bool connect = true;

  [[nodiscard]] bool has_drivers() const {
    return std::ranges::any_of(devices, [](const auto& one) { return one.second.driver != nullptr; });
  }
  [[nodiscard]] const Binding* find(std::string_view device) const {
    const auto found = devices.find(device);
    return found == devices.end() ? nullptr : &found->second;
  }
};

/// A site file; the drivers of the process are in it (DriverKinds).
[[nodiscard]] const FormOf<Site>& site_form();
/// Reads a site file. @return it, or all diagnostics with file and pointer. Realtime: setup.
[[nodiscard]] Result<Site> read_site(const std::filesystem::path& file);
[[nodiscard]] Result<Site> parse_site(std::string_view text);

/// Adds what --backend says, "NAME=KIND[:ADDR]", over what a site file said of that device. For kind "slow" ADDR is a
/// list of "8ms", "drift=100ppm", "jitter=0.3ms", "loss=1%" and the like; for "terminals" the name of an arm; for a
/// driver it is "ADDRESS,key=value,...", with the keys of the site file and, in place of "_ms", "_ppm" and a share, the
/// units ms, ppm and %. Realtime: setup.
[[nodiscard]] Diagnostics bind(Site& site, std::string_view argument);

/// Lock-step knows no device with a clock of its own (row T4). @return an error for each that is bound so.
[[nodiscard]] Diagnostics check_clocks(const Site& site, bool realtime,
                                       const std::vector<BackendKind>& kinds = backend_kinds());

}  // namespace takt::cell
