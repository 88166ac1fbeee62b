#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/remote/server_link.h"
#include "cell/build/built_cell.h"
#include "cell/build/sample_tape.h"
#include "cell/judge/expectation_result.h"
#include "core/rcc/command_relay.h"

namespace takt::app {

/// What a server says of the cell that it has.
struct ServedCell {
  std::string file, hash, version;
  std::uint64_t seed = 0;
  bool realtime = false;
};

/// The core of a program whose cell is in another process (docs/remote.md, "A program in another process"). What the
/// program asks of its core goes to the server's; that core has the devices, and its cycle is the one that counts. This
/// core follows: in each cycle it gets what the devices there have read and which commands were taken there, runs the
/// same cycle, and compares what came of it. So everything that a program reads of its core, of nets and of devices is
/// here, and is what it is there. Owned by the core. Thread: the program's.
class Follower final : public rcc::CommandRelay {
 public:
  /// Silence of this process, cycles, after which what it started comes to rest; in real time.
  static constexpr std::int64_t kLease = 1000;

  /// Asks a server for its cell. Throws nothing. @return it, or why not
  [[nodiscard]] static Result<ServedCell> ask(ServerLink& link);

  /// All of it outlives the follower.
  Follower(ServerLink& link, cell::BuiltCell& built, const ServedCell& served)
      : link_(link), built_(built), served_(served) {}

  /// Takes the lease, and brings the core and its devices into the state that the cell is in. @return why not
  [[nodiscard]] Diagnostics begin();
  /// Lock-step: one cycle. In real time those that were run meanwhile, at least one. @return false: it cannot go on,
  /// see why_not()
  [[nodiscard]] bool next();
  [[nodiscard]] const Diagnostics& why_not() const { return failure_; }
  /// What has happened in the cycles of the last next().
  [[nodiscard]] const std::vector<rcc::Event>& events() const { return events_; }

  /// @param value  nothing: null
  void write_channel(const std::string& name, const std::optional<device::ChannelValue>& value);
  /// What the program means to touch just now.
  void touching(const std::set<std::string, std::less<>>& devices);
  void note(std::string_view source, std::string_view name, std::string_view text);
  void step_begun(std::string_view name);
  struct Verdict {
    std::string digest;
    std::int64_t cycles = 0;
    std::vector<cell::ExpectationResult> expectations;
  };
  /// What the server makes of the run so far. @return nothing: it does not answer, see why_not()
  [[nodiscard]] std::optional<Verdict> judge();

  /// Lets go of the cell: the next program may have it. Nothing of this one follows any more.
  void leave();

  // -- What the core relays ------------------------------------------------------------------------------------------
  [[nodiscard]] Diagnostics load(rcc::NetId net, const net::NetDescription& description,
                                 const rcc::LoadOptions& options) override;
  [[nodiscard]] bool post(rcc::RequestId id, const rcc::Rule& rule) override;
  [[nodiscard]] bool change_mode(rcc::RequestId id, std::string_view arm, device::ControlMode mode) override;
  void abort(rcc::NetId net) override;
  void unload(rcc::NetId net) override;
  void stop_all(net::Cause::Code code, std::string_view text) override;

 private:
  /// What was asked for, until a cycle has taken it.
  struct Asked {
    enum class Kind : std::uint8_t { kRule, kMode, kAbort, kUnload, kOther };
    Kind kind = Kind::kOther;
    rcc::RequestId id = 0;
    rcc::Rule rule = {};
    rcc::NetId net = 0;
    std::string arm = {};
    device::ControlMode mode = device::ControlMode::kPosition;
  };
  [[nodiscard]] std::uint32_t keep(Asked asked);
  void tell_tool(const std::string& arm, const device::ToolSetting& tool);
  bool fail(Code code, std::string message, std::string hint);
  [[nodiscard]] bool take(const ServerLink::Message& message);
  [[nodiscard]] bool take_text(const std::string& text);
  [[nodiscard]] bool take_record(std::span<const std::byte> record);
  [[nodiscard]] bool take_begin(cell::ByteReader& in);
  [[nodiscard]] bool take_cycle(cell::ByteReader& in);
  [[nodiscard]] bool take_command(std::uint32_t tag, bool posted);

  ServerLink& link_;
  cell::BuiltCell& built_;
  ServedCell served_;
  std::uint32_t fence_ = 0, last_tag_ = 0;
  std::map<rcc::NetId, rcc::NetId> there_;  ///< number of a net in the other core
  std::map<std::uint32_t, Asked> asked_;
  std::vector<rcc::Event> events_;
  std::int64_t cycles_ = 0;  ///< that were taken in so far
  bool begun_ = false, left_ = false;
  std::set<std::string, std::less<>> touching_;
  std::optional<Verdict> verdict_;
  Diagnostics failure_;
};

}  // namespace takt::app
