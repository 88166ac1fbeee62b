#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <boost/lockfree/spsc_queue.hpp>

#include "cell/run/follow_record.h"
#include "core/rcc/lease.h"
#include "core/rcc/request_queue.h"

namespace takt::serve {

/// What a follower asks of the core, resolved: nets and ports are those of this core.
struct FollowCommand {
  enum class Kind : std::uint8_t { kRule, kAbort, kUnload, kMode, kStop, kChannel, kTool };
  Kind kind = Kind::kRule;
  std::uint32_t tag = 0;  ///< the follower's number of it
  rcc::Rule rule = {};
  rcc::NetId net = 0;
  device::Arm* arm = nullptr;
  device::ControlMode mode = device::ControlMode::kPosition;
  device::Channel* channel = nullptr;
  std::optional<device::ChannelValue> value = {};
  device::ToolSetting tool = {};
  net::Text text = {};
};

/// What a follower needs to be in the same state as this cell: where it begins, then of each cycle what the devices
/// read and which commands were taken (docs/remote.md, "A program in another process"). Commands come by a bounded
/// queue and are given to the core right before a cycle, so it is known which one; what is told goes out by a bounded
/// queue, and a follower that takes too long loses its place. The cycle waits for neither.
class FollowLog {
 public:
  static constexpr std::size_t kRecordBytes = 6144, kRecords = 2048, kCommands = 256;

  FollowLog(cell::BuiltCell& built, rcc::Lease& lease) : built_(built), lease_(lease) {}

  // -- The thread of the server
  // ----------------------------------------------------------------------------------------
  /// What of the cell cannot be followed: devices whose readings are not known. Empty: nothing.
  [[nodiscard]] std::vector<std::string> missing() const;
  /// Asks for it; what comes of it is the first record. @return false: somebody follows already
  [[nodiscard]] bool begin(std::uint32_t fence);
  void end();
  /// @return false: there is no room, or nobody follows
  [[nodiscard]] bool push(const FollowCommand& command) { return state_ == State::kOn && commands_.push(command); }
  /// The next record; nothing: there is none yet.
  [[nodiscard]] std::optional<std::string> pop();

  // -- Whoever runs the cell
  // -------------------------------------------------------------------------------------------
  /// Between two cycles: a follower that waits begins, if the cell is at rest.
  void look();
  /// Right before each cycle, and after it. Realtime: cyclic.
  void before_cycle();
  /// All nets were ended before this cycle, by somebody else. Realtime: cyclic.
  void stopped(const net::Text& why);
  void after_cycle();

 private:
  enum class State : std::uint8_t { kOff, kWanted, kOn, kEnding };
  struct Record {
    std::array<std::byte, kRecordBytes> bytes;
    std::size_t size = 0;
  };
  void carry_out(const FollowCommand& command);
  [[nodiscard]] std::string refusal() const;
  void write_begin(Record& record);
  void write_cycle(Record& record);
  void tell(cell::FollowRecord kind, std::string_view text);
  void push(const Record& record);

  cell::BuiltCell& built_;
  rcc::Lease& lease_;
  std::atomic<State> state_ = State::kOff;
  std::atomic<std::uint32_t> fence_ = 0;
  rcc::RequestQueue<FollowCommand, kCommands> commands_;
  std::unique_ptr<boost::lockfree::spsc_queue<Record>> records_;
  bool lost_ = false;  ///< of whoever runs the cell: there was no room for a record

  struct Taken {
    std::uint32_t tag;
    bool posted;
  };
  std::array<Taken, kCommands> taken_{};
  std::size_t taken_count_ = 0;
  net::Text stop_ = {};  ///< of this cycle
  bool stopped_ = false;
  Record scratch_;
};

}  // namespace takt::serve
