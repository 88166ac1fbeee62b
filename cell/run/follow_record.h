#pragma once

#include <cstdint>
#include <string>

#include "cell/build/built_cell.h"
#include "cell/build/sample_tape.h"

/// What a cell that is followed tells the one that follows it, both built from the same file (docs/remote.md, "A
/// program in another process"). Numbers are little-endian, without filling; every record begins with its kind (u8).
namespace takt::cell {

enum class FollowRecord : std::uint8_t {
  kBegin = 3,    ///< i64 cycle that was run last; the state after it (write_state); what the devices have read
  kCycle = 4,    ///< see FollowedCycle; then what the devices have read
  kRefused = 5,  ///< text: why the cell cannot be followed now
  kLost = 6      ///< text: why it cannot be followed any more
};

/// What a cell is in besides what its devices read: set points of all that is driven, tools, channels. For a cell at
/// rest that no net holds. Realtime: cyclic.
void write_state(const BuiltCell& built, ByteWriter& out);
/// The same in a cell that follows and has run no cycle: it is in that state after one cycle with the readings that
/// come behind the state. @param tools  as they were told there, by arm. @return false: this is the state of another
/// cell
[[nodiscard]] bool restore_state(ByteReader& in, BuiltCell& built, std::int64_t cycle,
                                 std::map<std::string, device::ToolSetting, std::less<>>& tools);

/// The values that came into channels from outside at the beginning of this cycle. Realtime: cyclic.
void write_latched(const BuiltCell& built, ByteWriter& out);
/// The same, written into the channels. @return false: this is of another cell
[[nodiscard]] bool read_latched(ByteReader& in, BuiltCell& built);

/// Of all that nets drive in a cell, as it is known in this cycle and as it was sent: two cells in the same state have
/// the same. Realtime: cyclic.
[[nodiscard]] std::uint64_t hash_of_actuators(const expression::Cell& cell);

void put_text(std::string_view text, ByteWriter& out);  ///< u8 size, bytes
[[nodiscard]] std::string get_text(ByteReader& in);

}  // namespace takt::cell
