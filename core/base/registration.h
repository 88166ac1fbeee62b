#pragma once

#include <string>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt {

/// One thing that a plug-in brings to a registry of the process: a primitive, a kind of device. It is made when the
/// plug-in is loaded and touches nothing of takt by that; the loader checks all of a plug-in's, then adds all or none.
/// Lives as long as the process. Thread: the one that loads. Realtime: setup.
class Registration {
 public:
  virtual ~Registration() = default;
  Registration(const Registration&) = delete;
  Registration& operator=(const Registration&) = delete;

  /// What it is, for people: "primitive", "device kind".
  [[nodiscard]] virtual std::string_view what() const = 0;
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// Why it cannot be added: the name is taken, the declaration is broken. Pointers are empty.
  [[nodiscard]] virtual Diagnostics check() const = 0;
  virtual void add() = 0;

  /// The one declared before it in the same plug-in, or null.
  [[nodiscard]] Registration* next() const { return next_; }

 protected:
  explicit Registration(Registration*& list) : next_(list) { list = this; }

 private:
  Registration* next_;
};

/// The registrations of this library. Hidden, so that each plug-in has a list of its own: were it shared, a plug-in
/// that is refused would have touched the program already.
[[gnu::visibility("hidden")]] inline Registration* own_registrations = nullptr;

}  // namespace takt
