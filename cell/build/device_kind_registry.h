#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cell/build/device_kind.h"
#include "core/base/registration.h"

namespace takt::cell {

/// All kinds of the process, in the order of their names. Realtime: setup.
class DeviceKinds {
 public:
  /// Ours are there from the beginning.
  static DeviceKinds& global();
  /// A name that is taken is a programming error (abort); plug-ins ask first.
  void add(std::unique_ptr<DeviceKind> kind);
  [[nodiscard]] const DeviceKind* find(std::string_view name) const;
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  DeviceKinds();
  std::vector<std::unique_ptr<DeviceKind>> kinds_;
};

/// The kind of the model in this folder and the model, read.
struct ReadModel {
  const DeviceKind* kind = nullptr;
  ModelPointer model;
};
/// Diagnostics are those of the file; a kind that is none of a cell gets `pointer`, the place that asked for the model.
[[nodiscard]] Result<ReadModel> read_model(const std::filesystem::path& folder, const std::string& pointer = {});

/// A kind of a plug-in, waiting for the loader.
class DeviceKindRegistration final : public Registration {
 public:
  DeviceKindRegistration(Registration*& list, std::unique_ptr<DeviceKind> kind)
      : Registration(list), name_(kind->name()), kind_(std::move(kind)) {}

  [[nodiscard]] std::string_view what() const override { return "device kind"; }
  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] Diagnostics check() const override;
  void add() override { DeviceKinds::global().add(std::move(kind_)); }

 private:
  std::string name_;
  std::unique_ptr<DeviceKind> kind_;
};

/// Registers a kind of device in a plug-in: a class derived from DeviceKind that needs nothing to be made.
///   TAKT_DEVICE_KIND(FanKind);
#define TAKT_DEVICE_KIND(Class) \
  ::takt::cell::DeviceKindRegistration registration_of_##Class(::takt::own_registrations, std::make_unique<Class>())

}  // namespace takt::cell
