#pragma once

#include <concepts>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/interfaces/actuator_interfaces.h"

namespace takt::app {

class DeviceInterface;

/// An actuator in a composed device, by what it is there: {"torch", lamp}.
struct DevicePart {
  std::string role;
  Actuator actuator;
};

/// Several actuators of a cell as one thing with a name: a robot with its torch, an arm with its gripper. Each part may
/// be commanded by itself as well. What only the whole can do (weld()) is an interface of the program's own
/// (DeviceInterface), made of activities of the parts (composition.h). A cheap value. Thread: the program's. Realtime:
/// setup.
class ComposedDevice {
 public:
  /// Throws ActivityError without parts, for an actuator or a role that is named twice, and for parts of several
  /// runtimes.
  ComposedDevice(std::string name, std::vector<DevicePart> parts);
  /// Their roles are their names.
  ComposedDevice(std::string name, std::initializer_list<Actuator> parts);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<DevicePart>& parts() const { return parts_; }
  /// By its role, or by its own name. Throws ActivityError, with the nearest, if it has no such part.
  [[nodiscard]] const Actuator& part(const std::string& role) const;
  [[nodiscard]] bool has_part(const std::string& role) const { return find(role) != nullptr; }

  /// An interface of the whole, or that of the one part that offers it. Throws ActivityError if none does, or several
  /// do.
  template <class Interface>
  [[nodiscard]] Interface use() const {
    if constexpr (std::derived_from<Interface, DeviceInterface>) {
      if (!offers<Interface>()) refuse(Interface::kName);
      return Interface(*this);
    } else {
      return the_one(Interface::kName, &Interface::offered_by).template use<Interface>();
    }
  }
  template <class Interface>
  [[nodiscard]] bool offers() const {
    if constexpr (std::derived_from<Interface, DeviceInterface>) {
      return Interface::offered_by(*this);
    } else {
      return offering(&Interface::offered_by).size() == 1;
    }
  }
  /// Names of the interfaces that exactly one part offers.
  [[nodiscard]] std::vector<std::string> interfaces() const;

  /// Override, pause and resume of all arms among the parts (Runtime).
  void set_speed(double rate) const;
  void pause() const;
  void resume() const;

 private:
  using OfferedBy = bool (*)(const expression::Cell&, const std::string&);
  [[nodiscard]] const Actuator* find(const std::string& role) const;
  [[nodiscard]] std::vector<const Actuator*> offering(OfferedBy offered_by) const;
  [[nodiscard]] const Actuator& the_one(std::string_view interface, OfferedBy offered_by) const;
  [[noreturn]] void refuse(std::string_view interface) const;
  [[nodiscard]] std::vector<const Actuator*> arms() const;

  std::string name_;
  std::vector<DevicePart> parts_;
};

/// Base class of the interfaces that a program gives to composed devices: `welder.use<WeldingInterface>()`. A class
/// that derives from it has kName and `static bool offered_by(const ComposedDevice&)`, inherits the constructor, and
/// makes its activities of the parts.
class DeviceInterface {
 public:
  explicit DeviceInterface(ComposedDevice device) : device_(std::move(device)) {}
  [[nodiscard]] const ComposedDevice& device() const { return device_; }

 protected:
  /// Throws ActivityError if the device has no part with this role.
  [[nodiscard]] const Actuator& part(const std::string& role) const { return device_.part(role); }

 private:
  ComposedDevice device_;
};

}  // namespace takt::app
