#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>

namespace takt {

/// A file or a folder that nobody is to find if a signal ends the process: temporary, or not whole yet. This process
/// alone removes it, not a fork of it. Move-only. Realtime: setup.
class Unfinished {
 public:
  Unfinished() = default;
  /// @param writer  a process that writes it and is ended before; 0: none
  explicit Unfinished(const std::filesystem::path& path, pid_t writer = 0);
  ~Unfinished();
  Unfinished(Unfinished&& other) noexcept;
  Unfinished& operator=(Unfinished&& other) noexcept;

 private:
  std::size_t slot_ = kNone;
  static constexpr std::size_t kNone = ~std::size_t{0};
};

/// Removes all of them. For handlers of signals that end the process: async-signal-safe.
void remove_unfinished() noexcept;

}  // namespace takt
