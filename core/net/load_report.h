#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"

namespace takt::net {

/// The diagnostics of one LOAD, bounded in number and work, so that a net of 100 000 mistakes is rejected as fast as
/// one with a single mistake. Private to core/net.
class LoadReport {
 public:
  void error(Code code, std::string pointer, std::string message, std::string hint = {});
  void note(std::string pointer, std::string message, std::string hint = {});
  void append(const Diagnostics& diagnostics, std::string_view prefix);

  /// nearest_choice among what `choices` returns, while errors are still listed and work is left; else nothing.
  template <class Choices>
  [[nodiscard]] std::string nearest(std::string_view name, Choices choices) {
    return errors_ < kMostErrors && work_left_ > 0 ? nearest_of(name, choices()) : std::string();
  }

  [[nodiscard]] bool has_errors() const { return errors_ > 0; }
  /// The errors with a last one that counts those left out; the notes if there is no error.
  [[nodiscard]] Diagnostics take();

 private:
  std::string nearest_of(std::string_view name, const std::vector<std::string>& choices);

  static constexpr std::size_t kMostErrors = 1000;
  Diagnostics diagnostics_;
  std::size_t errors_ = 0;
  std::size_t work_left_ = 20'000'000;  ///< character comparisons: some 50 ms
};

/// A name from the input for a message: cut after 64 bytes.
[[nodiscard]] std::string shown(std::string_view name);

}  // namespace takt::net
