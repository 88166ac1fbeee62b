#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/device/device.h"
#include "core/device/mailbox.h"
#include "core/net/value.h"

namespace takt::device {

/// A value of any port type; the index is the net::ValueType.
using ChannelValue = std::variant<net::Boolean, net::Integer, net::Real, net::Text, net::Vector, net::Rotation,
                                  net::Frame, net::Twist, net::Wrench, net::JointArray>;

/// What a channel is declared as (docs/channels.md).
struct ChannelDescription {
  enum class Writer : std::uint8_t {
    kOutside,  ///< any thread, through Channel::write()
    kNet       ///< one net at a time, which holds the channel while it runs
  };
  std::string name;
  net::ValueType type = net::ValueType::kReal;
  Writer writer = Writer::kOutside;
  std::string unit = {};   ///< as in a PortSpec, without variables; for types that carry a unit, empty = "1"
  std::string frame = {};  ///< "A>B" or "A" with the names of the cell; empty = not checked
  std::optional<ChannelValue> initial = {};  ///< read until the first value comes; empty = null
  Nanoseconds timeout = 0;                   ///< a value that is older reads as null; 0 = it never grows too old
};

/// A named, typed value in the control core: what the outside or one net writes, all nets and monitors read (row O5).
///
/// One value holds for a whole cycle. What came from outside counts from the cycle that begins next, the newest wins.
/// What a net writes in cycle k is read in k+1, by itself too, so that the order among nets cannot be observed; what a
/// net writes in the cycle in which it is aborted is lost (row L2). The value stays when its net has ended, and ages.
/// write() may be called from any thread; the rest is for the cycle thread once the core runs.
class Channel final : public Device {
 public:
  /// The kind of a channel of this type, "Real channel": a primitive of another type does not find it.
  [[nodiscard]] static std::string_view kind_of(net::ValueType type);

  /// @return the channel, or all that is wrong with its description; pointers are relative to it. Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<Channel>> make(const ChannelDescription& description);

  [[nodiscard]] std::string_view kind() const override { return kind_of(description_.type); }
  [[nodiscard]] const net::Signal* signal() const override { return &signal_; }
  [[nodiscard]] const ChannelDescription& description() const { return description_; }

  // -- From outside. Any thread, wait-free. --------------------------------------------------------------------------
  enum class Written : std::uint8_t {
    kDone,
    kWrongType,  ///< the channel carries another type
    kNetWrites,  ///< this channel is written by nets
    kBusy        ///< fifteen threads are writing this channel just now; try again
  };
  /// What is not finite becomes null (row N5).
  template <class T>
  Written write(const T& value) {
    return write_slot(net::kValueType<T>, [&value](std::byte* bytes) { slot_in<T>(bytes).set(value); });
  }
  Written write_null();
  Written write(const ChannelValue& value);

  // -- The cycle. Realtime: cyclic. ----------------------------------------------------------------------------------
  void begin_cycle(std::int64_t cycle, Nanoseconds time) override;
  void add_state(StateWords& words) const override;

  /// The value of this cycle; the address never changes. T as declared.
  template <class T>
  [[nodiscard]] const net::Slot<T>& slot() const {
    return *reinterpret_cast<const net::Slot<T>*>(shown_.data());
  }
  [[nodiscard]] const void* raw_slot() const { return shown_.data(); }
  [[nodiscard]] std::size_t slot_size() const { return slot_size_; }
  /// Since the cycle in which the value came or was written; nothing before the first.
  [[nodiscard]] std::optional<Nanoseconds> age() const;
  /// The value that came before the newest one; null before the second, and if the newest came after the timeout of
  /// that one. The address never changes. T as declared.
  template <class T>
  [[nodiscard]] const net::Slot<T>& previous() const {
    return *reinterpret_cast<const net::Slot<T>*>(previous_.data());
  }
  /// From the cycle in which that one came to the cycle in which the newest did; 0: there is none.
  [[nodiscard]] Nanoseconds interval() const { return interval_; }
  /// A value came from outside at the beginning of this cycle.
  [[nodiscard]] bool latched() const { return latched_; }

  /// What the net that holds the channel writes in this cycle. T as declared.
  template <class T>
  void put(const net::In<T>& value) {
    if (value.null()) {
      slot_in<T>(pending_.data()).set_null();
    } else {
      slot_in<T>(pending_.data()).set(*value);
    }
    has_pending_ = true;
  }
  /// The net was aborted in this cycle: what it wrote is lost.
  void drop() { has_pending_ = false; }

 private:
  static constexpr std::size_t kBytes = 192;
  using Bytes = std::array<std::byte, kBytes>;

  explicit Channel(const ChannelDescription& description);

  template <class T>
  static net::Out<T> slot_in(std::byte* bytes) {
    static_assert(sizeof(net::Slot<T>) <= kBytes && sizeof(net::Slot<T>) % sizeof(std::uint64_t) == 0);
    return net::Out<T>(reinterpret_cast<net::Slot<T>*>(bytes));
  }
  static void set_null(net::ValueType type, std::byte* bytes);
  static void set(std::byte* bytes, const ChannelValue& value);

  /// The newest value becomes the one before, as another one came at this time.
  void keep_previous(Nanoseconds time);

  template <class Fill>
  Written write_slot(net::ValueType type, Fill fill) {
    if (type != description_.type) return Written::kWrongType;
    if (description_.writer != ChannelDescription::Writer::kOutside) return Written::kNetWrites;
    return mailbox_.put(fill) ? Written::kDone : Written::kBusy;
  }

  ChannelDescription description_;
  net::Signal signal_;
  std::size_t slot_size_;
  alignas(64) Bytes shown_{};    ///< what nets read in this cycle
  alignas(64) Bytes pending_{};  ///< what a net wrote in this cycle
  alignas(64) Bytes previous_{};
  Mailbox<kBytes> mailbox_;
  bool has_pending_ = false, latched_ = false, has_value_ = false;
  Nanoseconds time_ = 0, written_ = 0;  ///< of this cycle; of the cycle of the newest value
  Nanoseconds interval_ = 0;
};

/// What lies in a slot of this type; nothing for null. Realtime: setup.
[[nodiscard]] std::optional<ChannelValue> value_in(net::ValueType type, const void* slot);

/// A value for people and files: the type's form of net parameters. Realtime: setup.
[[nodiscard]] std::string to_text(const ChannelValue& value);

}  // namespace takt::device
