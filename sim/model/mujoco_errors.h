#pragma once

#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/diagnostics.h"

namespace takt::sim {

/// MuJoCo's fatal error as a C++ exception: thrown by the handler in place of ending the process. It leaves MuJoCo's
/// own frames behind, so the mjData or mjModel it was working on may only be destroyed afterwards.
class MujocoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Routes MuJoCo's errors (-> MujocoError) and warnings (-> mujoco_warnings()) to us, and keeps it from writing its log
/// file. Everything in sim/ calls this before its first MuJoCo call; calling it again costs one atomic read.
/// Thread: any. Realtime: setup.
void install_mujoco_handlers();

/// How many warnings MuJoCo has given in this process, and the text of the last one. MuJoCo warns once per kind and
/// mjData, so a count that grows is news. Thread: any.
struct MujocoWarnings {
  std::uint64_t count = 0;
  std::string last;
};
[[nodiscard]] MujocoWarnings mujoco_warnings();

/// Runs `work` with the handlers in place; a MujocoError becomes a diagnostic at `pointer`: "MuJoCo: TEXT".
/// @return what `work` returns (nothing for void), or the diagnostic.
/// Thread: any. Realtime: costs nothing while no error occurs.
template <std::invocable F>
[[nodiscard]] Result<std::invoke_result_t<F>> mujoco_call(const std::string& pointer, F&& work) {
  install_mujoco_handlers();
  try {
    if constexpr (std::is_void_v<std::invoke_result_t<F>>) {
      std::forward<F>(work)();
      return {};
    } else {
      return std::forward<F>(work)();
    }
  } catch (const MujocoError& error) {
    return failure(Code::kSystem, pointer, std::string("MuJoCo: ") + error.what());
  }
}

}  // namespace takt::sim
