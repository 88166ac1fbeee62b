#pragma once

#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "core/net/compiled_net.h"
#include "tests/support/allocation_guard.h"

namespace takt {

inline void PrintTo(const Diagnostic& diagnostic, std::ostream* stream) { *stream << to_string(diagnostic); }

}  // namespace takt

namespace takt::net {

class TestDevice : public Resource {
 public:
  explicit TestDevice(std::string kind) : kind_(std::move(kind)) {}
  [[nodiscard]] std::string_view kind() const override { return kind_; }

 private:
  std::string kind_;
};

/// Devices by name; empty to begin with.
class TestDevices : public Environment {
 public:
  TestDevices& add(const std::string& name, const std::string& kind) {
    devices_[name] = std::make_unique<TestDevice>(kind);
    return *this;
  }
  Resource* find(std::string_view name) override {
    const auto found = devices_.find(std::string(name));
    return found == devices_.end() ? nullptr : found->second.get();
  }
  [[nodiscard]] std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const auto& [name, device] : devices_) names.push_back(name);
    return names;
  }

 private:
  std::map<std::string, std::unique_ptr<Resource>> devices_;
};

inline std::unique_ptr<CompiledNet> make_net(const NetDescription& description) {
  TestDevices devices;
  auto net = CompiledNet::compile(description, devices);
  if (net) return std::move(*net);
  ADD_FAILURE() << net.error().to_string();
  return nullptr;
}

inline void run(CompiledNet& net, int cycles) {
  for (int i = 0; i < cycles; ++i) {
    Cycle cycle;
    cycle.index = net.cycles();
    const test::AllocationGuard guard;
    net.evaluate(cycle);
    const std::size_t allocations = guard.count();
    EXPECT_EQ(allocations, 0u);
  }
}

inline std::optional<double> real(const CompiledNet& net, std::string_view port) {
  const Slot<Real>* slot = net.find<Real>(port);
  if (slot == nullptr) {
    ADD_FAILURE() << "no port " << port;
    return std::nullopt;
  }
  return slot->null != 0 ? std::nullopt : std::optional<double>(slot->value);
}

}  // namespace takt::net
