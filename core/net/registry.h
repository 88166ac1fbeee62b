#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/registration.h"
#include "core/net/primitive.h"

namespace takt::net {

/// What is known of a primitive type without an instance; made by running its constructor once in describing mode.
struct PrimitiveInfo {
  struct Port {
    std::string name;
    ValueType type;
    PortSpec spec;
  };
  struct Parameter {
    std::string name;
    std::string type;  ///< "Real", "Joints", ..., "json", or "device:KIND"
    ParameterSpec spec;
    std::string fallback;  ///< JSON text of the default; empty = must be given
  };
  struct LatencyEntry {
    std::string in, out;
    Latency latency;
    std::string cycles_parameter = {};  ///< Integer parameter that gives the cycles of an instance; empty: `latency`
  };
  std::string type, family, doc;
  std::vector<Port> inputs, outputs;
  std::vector<Parameter> parameters;
  std::vector<LatencyEntry> latencies;
  std::vector<std::string> loop_breaking_inputs;
  std::vector<std::string> flags;              ///< Boolean inputs at which a net may declare what null counts as
  std::vector<std::string> bridgeable_inputs;  ///< inputs at which it may declare a number of bridged cycles
  std::vector<std::vector<std::string>> exclusive_outputs;
  struct Meaning {
    std::string output, formula;
  };
  std::vector<Meaning> meanings;
  bool termination = false, monitor = false, merge = false;
  bool source = false;  ///< its outputs come from outside the net: a device, an operator, a channel
  /// Of the kind that hears of a cancel: the parameter with the net's bound; empty: another kind.
  std::string cancel_bound;
  double cost_ns = 4.0;  ///< of an update on the reference machine
  std::string claims;    ///< parameter that names the claimed device; empty = none
};

/// How instances of a class are made: in place, so that a net can keep its primitives side by side in one arena.
struct Maker {
  std::size_t size = 0, alignment = 1;
  Primitive* (*construct)(void* place, Setup& setup) = nullptr;

  template <class Class>
  static Maker of() {
    return {sizeof(Class), alignof(Class),
            [](void* place, Setup& setup) -> Primitive* { return ::new (place) Class(setup); }};
  }
};

/// All primitive types of the process, in a fixed order (by name).
class Registry {
 public:
  static Registry& global();
  /// @return true, so that it can initialise a constant. A name registered twice is a programming error (abort).
  /// Realtime: setup; before the first look-up by another thread.
  bool add(std::string_view type, std::string_view family, std::string_view doc, Maker maker);
  /// What Setup::means() says, from outside the class: for templates that serve several types. Right after add().
  bool means(std::string_view type, std::string_view output, std::string_view formula);
  /// @return nullptr if there is no such type. The type is described at the first look-up. Thread: any.
  [[nodiscard]] const PrimitiveInfo* find(std::string_view type) const;
  [[nodiscard]] const Maker* maker(std::string_view type) const;
  [[nodiscard]] std::vector<const PrimitiveInfo*> all() const;
  [[nodiscard]] std::vector<std::string> names() const;
  /// Why a type cannot be added: its name is taken, or what it declares is broken. Realtime: setup.
  [[nodiscard]] Diagnostics check(std::string_view type, const Maker& maker) const;

 private:
  struct Entry;
  [[nodiscard]] const Entry* entry(std::string_view type) const;
  std::vector<std::unique_ptr<Entry>> entries_;  ///< by name

 public:
  Registry();
  ~Registry();
};

/// A primitive of a plug-in, waiting for the loader.
class PrimitiveRegistration final : public Registration {
 public:
  PrimitiveRegistration(Registration*& list, std::string_view type, std::string_view family, std::string_view doc,
                        const Maker& maker)
      : Registration(list), type_(type), family_(family), doc_(doc), maker_(maker) {}

  [[nodiscard]] std::string_view what() const override { return "primitive"; }
  [[nodiscard]] std::string_view name() const override { return type_; }
  [[nodiscard]] Diagnostics check() const override { return Registry::global().check(type_, maker_); }
  void add() override { Registry::global().add(type_, family_, doc_, maker_); }

 private:
  std::string_view type_, family_, doc_;
  Maker maker_;
};

/// Registers the class: type name, family, documentation of the whole. Ports and parameters document themselves.
///   TAKT_PRIMITIVE(Add, "arithmetic", "Sum of two values of one unit.");
/// In a plug-in (TAKT_PLUGIN_BUILD, which CMake's takt::plugin sets) the class waits for the loader.
#ifdef TAKT_PLUGIN_BUILD
#define TAKT_PRIMITIVE(Class, family, doc)                                                                   \
  ::takt::net::PrimitiveRegistration registration_of_##Class(::takt::own_registrations, #Class, family, doc, \
                                                             ::takt::net::Maker::of<Class>())
#else
#define TAKT_PRIMITIVE(Class, family, doc) \
  const bool k##Class##Registered =        \
      ::takt::net::Registry::global().add(#Class, family, doc, ::takt::net::Maker::of<Class>())

/// Says of a registered class of this program what a Boolean output means, from outside of a template. Elsewhere
/// Setup::means() says it.
///   TAKT_MEANING(Not, "value", "!input");
#define TAKT_MEANING(Class, output, formula) \
  const bool k##Class##Means = ::takt::net::Registry::global().means(#Class, output, formula)
#endif

}  // namespace takt::net
