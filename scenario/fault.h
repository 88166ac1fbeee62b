#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "core/table/kinds.h"

namespace takt::scenario {

class Fault;
struct BuiltCell;

/// What faults act on in a run. Thread: the session's.
struct FaultContext {
  /// The button of a cabinet, beside the core's latch.
  struct Button {
    std::optional<Nanoseconds> brakes_at = {};  ///< when its circuit closes all brakes
    bool reset_pending = true;                  ///< the reset button is pressed in the next cycle
  };
  using Note = std::function<void(std::string_view what, std::string_view text)>;

  BuiltCell& built;
  std::uint64_t seed;  ///< of the scenario
  Nanoseconds now = 0;
  Button button = {};
  std::vector<const Fault*> active = {};  ///< that last, in the order of their beginnings
  const Note* note = nullptr;             ///< tells the log
};

/// When a fault may happen, s.
inline constexpr Range kFaultTime{.low = 0.0, .high = 3600.0};
/// How long one may last, s.
inline constexpr Range kFaultDuration{.low = 0.0, .high = 3600.0, .low_open = true};

/// One entry of "faults": something that happens to the machines at one time, whatever the program does. It has no
/// state of a run. Realtime: setup, but for begin() and end().
class Fault {
 public:
  virtual ~Fault() = default;

  /// Checks names against the cell, and gives the cell what the fault needs.
  virtual void add_to(BuiltCell& built, Diagnostics& diagnostics) const = 0;
  /// It happens now. A fault that lasts is in `context.active` already.
  virtual void begin(FaultContext& context) const = 0;
  /// A fault that lasts is over, and no longer in `context.active`.
  virtual void end(FaultContext&) const {}
  /// It takes the place of another one that still lasts.
  [[nodiscard]] virtual bool replaces(const Fault&) const { return false; }
  /// The device whose readings or connection fail; empty: none.
  [[nodiscard]] virtual std::string_view failing_device() const { return {}; }

  std::string kind = {}, pointer = {};
  Nanoseconds at = 0;
  std::optional<Nanoseconds> duration = {};  ///< nothing: it happens at once

 protected:
  Fault() = default;
  Fault(const Fault&) = default;
  Fault& operator=(const Fault&) = default;
  void note(const FaultContext& context, std::string_view text) const { (*context.note)(kind, text); }
};

/// Defined in a file of its name and listed once in fault.cc; a plug-in brings one with TAKT_FAULT.
using FaultKind = table::Kind<std::unique_ptr<Fault>>;

/// A kind whose faults are filled by a table.
template <class F, const table::Table<F>& (*table)()>
FaultKind fault_kind(std::string_view name, std::string_view doc) {
  return {.name = name,
          .doc = doc,
          .keys = ::takt::table::object_of<table>,
          .read = [](ObjectReader& reader) -> std::unique_ptr<Fault> {
            auto fault = std::make_unique<F>();
            table().read_into(*fault, {reader});
            return fault;
          }};
}

/// All kinds of the process. Ours are there from the beginning.
[[nodiscard]] table::Kinds<std::unique_ptr<Fault>>& fault_kinds();

using FaultList = std::vector<std::shared_ptr<const Fault>>;
/// Reads the key "faults": diagnostics for what is wrong, the entries in the order of their times. Realtime: setup.
[[nodiscard]] FaultList read_faults(ObjectReader& reader);

/// What "do" says where it is not given.
inline constexpr const char* kFaultByDefault = "stop";
/// An entry of "faults" of any kind, as data.
[[nodiscard]] const table::Field& fault_form();

/// Registers a kind of fault in a plug-in: a function without parameters that returns it.
///   TAKT_FAULT(spill_fault);
#define TAKT_FAULT(make)                                                                            \
  ::takt::table::KindRegistration<std::unique_ptr<::takt::scenario::Fault>> registration_of_##make( \
      ::takt::own_registrations, ::takt::scenario::fault_kinds(), make())

}  // namespace takt::scenario
