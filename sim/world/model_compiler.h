#pragma once

#include <memory>

#include "core/base/diagnostics.h"
#include "sim/world/world.h"

struct mjModel_;
struct mjData_;
struct mjSpec_;

namespace takt::sim {

struct MujocoDeleter {
  void operator()(mjSpec_* spec) const;
  void operator()(mjModel_* model) const;
  void operator()(mjData_* data) const;
};
template <class T>
using Owned = std::unique_ptr<T, MujocoDeleter>;

/// MuJoCo's model of a world: of pictures, or of the physics, which searches only for contacts that can be.
/// @param hook  see World::create
/// Errors: what MuJoCo's compiler says. Realtime: setup.
[[nodiscard]] Result<Owned<mjModel_>> compile_model(const WorldDescription& description, bool visuals,
                                                    const SpecHook& hook);

/// The state of a simulation of that model. @return a diagnostic: the system does not give the memory. Realtime: setup.
[[nodiscard]] Diagnostics make_data(const mjModel_& model, Owned<mjData_>& data);

}  // namespace takt::sim
