#pragma once

#include <string>
#include <vector>

#include "core/operations/actuator_interfaces.h"

namespace takt::activity {

/// Several actuators of a cell as one thing with a name: a robot with its torch, an arm with its gripper. Each part may
/// be commanded by itself as well. A class of a project derives from it, or holds one, and adds what the whole
/// can do (weld()), made of activities of the parts (composition.h). A cheap value. Thread: the program's. Realtime:
/// setup.
class ComposedDevice {
 public:
  /// Throws ActivityError without parts, for a part that is named twice, and for parts of several runtimes.
  ComposedDevice(std::string name, std::vector<Actuator> parts);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<Actuator>& parts() const { return parts_; }
  /// Throws ActivityError, with the nearest name, if it has no such part.
  [[nodiscard]] const Actuator& part(const std::string& name) const;

  /// The interface of the one part that offers it. Throws ActivityError if none does, or several do.
  template <class Interface>
  [[nodiscard]] Interface use() const {
    return the_one(Interface::kName, &Interface::offered_by).template use<Interface>();
  }
  template <class Interface>
  [[nodiscard]] bool offers() const {
    return offering(&Interface::offered_by).size() == 1;
  }
  /// Names of the interfaces that exactly one part offers.
  [[nodiscard]] std::vector<std::string> interfaces() const;

  /// Override, pause and resume of all arms among the parts (Runtime).
  void set_speed(double rate) const;
  void pause() const;
  void resume() const;

 private:
  using OfferedBy = bool (*)(const command::Cell&, const std::string&);
  [[nodiscard]] std::vector<const Actuator*> offering(OfferedBy offered_by) const;
  [[nodiscard]] const Actuator& the_one(std::string_view interface, OfferedBy offered_by) const;
  [[nodiscard]] std::vector<const Actuator*> arms() const;

  std::string name_;
  std::vector<Actuator> parts_;
};

}  // namespace takt::activity
