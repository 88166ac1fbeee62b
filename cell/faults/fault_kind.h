#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "cell/faults/fault.h"
#include "core/base/form.h"
#include "core/base/kind_registry.h"

namespace takt::cell {

/// What a fault is made from: its keys, and the cell. Realtime: setup.
class FaultReader : public FormReader {
 public:
  FaultReader(const Form& form, ObjectReader& object, BuiltCell& cell) : FormReader(form, object), built(cell) {}

  /// Key "seconds". @param absent  s
  [[nodiscard]] Nanoseconds duration(double absent);
  /// A key of seconds.
  [[nodiscard]] Nanoseconds time(std::string_view key);
  /// A key that may name a device; empty: all. @param what  it is, for the diagnostic of an unknown name
  [[nodiscard]] std::string device(std::string_view key, std::string_view what, const std::vector<std::string>& names);

  BuiltCell& built;
};

/// A kind of fault: the word in "do", its keys besides "at_s", and what is made of them. Ours and those of plug-ins use
/// the same way (docs/tables.md).
struct FaultKind {
  static constexpr std::string_view kWhat = "fault";
  /// Ours are there from the beginning.
  static KindRegistry<FaultKind>& registry();

  std::string name;
  Form form;
  std::function<std::unique_ptr<Fault>(FaultReader&)> make;
  bool of_machine = false;  ///< happens to a machine, with or without the core: to an emulated one too
};

/// kMachine: it happens to a machine, with or without the core; kCore: it needs the core, or lies between the two.
enum class Concerns { kMachine, kCore };

/// A kind whose fault is made by a constructor. @param F  Fault(FaultReader&)
template <class F>
[[nodiscard]] FaultKind fault_kind(std::string name, Concerns concerns, Form form) {
  return {.name = std::move(name),
          .form = std::move(form),
          .make = [](FaultReader& from) { return std::make_unique<F>(from); },
          .of_machine = concerns == Concerns::kMachine};
}

/// Row "seconds". @param meaning  what holds without it
[[nodiscard]] Key duration_key(std::string meaning);

/// Registers a kind of fault in a plug-in: a function that returns a FaultKind.
///   TAKT_FAULT(blocked_fan_fault);
#define TAKT_FAULT(function) \
  ::takt::KindRegistration<::takt::cell::FaultKind> registration_of_##function(::takt::own_registrations, function())

}  // namespace takt::cell
