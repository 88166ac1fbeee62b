#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cell/build/built_cell.h"
#include "core/device/device_file.h"
#include "record/recording.h"

namespace takt::cell {

/// One block of what a digest covers in a cycle, with the names of the places in it.
struct DumpedBlock {
  struct Place {
    std::string name;
    std::size_t offset = 0, size = 0;  ///< bytes
  };
  std::string name;  ///< "net 'touch'", "device 'arm'", "simulation"
  std::vector<std::byte> bytes;
  std::vector<Place> places;  ///< in the order of their offsets
};

/// All blocks of the newest cycle, in the order in which the digest takes them (row D4). Directly after a cycle of the
/// core and of the world. The core has to keep its blocks. Realtime: setup.
[[nodiscard]] std::vector<DumpedBlock> dump_state(BuiltCell& built);

/// The first bit that differs between two dumps.
struct BitDifference {
  std::string block, place;
  std::size_t byte = 0;        ///< in the place, of the word that differs
  std::uint64_t a = 0, b = 0;  ///< the words of 64 bit, or what is left of the place
  int bit = 0;                 ///< lowest one that differs
  std::string note;            ///< in words, if it is no bit: a block that one side does not have
};
[[nodiscard]] std::optional<BitDifference> first_difference(const std::vector<DumpedBlock>& a,
                                                            const std::vector<DumpedBlock>& b);
/// "net 'touch', port clock.time: bit 0 (3ff0000000000000 against 3ff0000000000001)"
[[nodiscard]] std::string to_string(const BitDifference& difference);

/// Runs the scenarios of two recordings again up to a cycle in which their digests differ, and compares what the
/// digests cover. Diagnostics: a recording without a scenario, one that this build does not repeat bit for bit.
[[nodiscard]] Result<std::optional<BitDifference>> find_bit(const record::Recording& a, const record::Recording& b,
                                                            std::uint64_t cycle, const device::ModelLibrary& models);

}  // namespace takt::cell
