#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/newest_slot.h"
#include "core/device/driver.h"

namespace takt::hw {

/// Most terminals of a kind that an image has room for.
inline constexpr std::size_t kMostTerminals = 64;

/// The inputs of a block at one instant; terminals of a kind in the order of the model.
struct InputImage {
  std::uint64_t sequence = 0;  ///< counts images; 0: none yet
  Nanoseconds stamp = 0;       ///< when it was taken, on the core's clock
  std::uint64_t digital = 0;   ///< a bit each
  std::array<double, kMostTerminals> analog{};
  bool ready = false;  ///< the outputs accept values
  std::uint32_t fault = 0;
};

/// The outputs of a block as the core wants them.
struct OutputImage {
  std::uint64_t digital = 0;
  std::array<double, kMostTerminals> analog{};
};

/// The cycle's side of a block: the back ends of its terminals, on images that another thread exchanges. All terminals
/// see the same image in one cycle: it is taken when one of them is looked at for the second time. The first and the
/// last two functions are for the cycle thread, the middle two for the driver's.
class CycleImage {
 public:
  /// @param on_cycle  called before an image is taken, once in each cycle; may be empty
  explicit CycleImage(const device::IoDescription& io, std::function<void()> on_cycle = {});
  CycleImage(const CycleImage&) = delete;
  CycleImage& operator=(const CycleImage&) = delete;

  /// Their back ends; they point into the image.
  [[nodiscard]] const device::IoTerminals& terminals() const { return terminals_; }

  /// New inputs. Realtime: cyclic, wait-free.
  void publish(const InputImage& inputs) { inputs_.publish(inputs); }
  /// The newest outputs; those of the model's "initial" until the core has written some. Realtime: cyclic, wait-free.
  [[nodiscard]] const OutputImage& outputs() {
    return outputs_.take() || written_ ? (written_ = true, outputs_.value()) : initial_;
  }

  /// As of this cycle. Realtime: cyclic.
  [[nodiscard]] const InputImage& inputs() const { return inputs_.value(); }
  /// The terminal with this number is looked at. Realtime: as of on_cycle.
  void look(std::size_t terminal);

 private:
  template <class T>
  class Input;
  template <class T>
  class Output;

  std::function<void()> on_cycle_;
  std::vector<bool> seen_;
  NewestSlot<InputImage> inputs_;
  NewestSlot<OutputImage> outputs_;
  OutputImage initial_, wanted_;
  bool written_ = false;
  device::IoTerminals terminals_;
};

}  // namespace takt::hw
