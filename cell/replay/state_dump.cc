#include "cell/replay/state_dump.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "cell/replay/recorded_run.h"
#include "cell/run/recorded_models.h"
#include "cell/run/session.h"

namespace takt::cell {
namespace {

std::vector<std::byte> copy_of(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

/// Words of a device or a simulation, each a place.
void name_words(DumpedBlock& block, const std::function<std::string(std::size_t)>& name) {
  for (std::size_t i = 0; 8 * i < block.bytes.size(); ++i) {
    block.places.push_back({name(i), 8 * i, std::min<std::size_t>(8, block.bytes.size() - 8 * i)});
  }
}

DumpedBlock dump_net(const net::CompiledNet& net) {
  DumpedBlock block{.name = fmt::format("net '{}'", net.name()), .bytes = copy_of(net.slots()), .places = {}};
  for (const net::CompiledNet::Port& port : net.ports()) {
    block.places.push_back({"port " + port.name, port.offset, port.size});
  }
  return block;
}

DumpedBlock dump_device(const device::Device& device) {
  device::StateWords words;
  device.add_state(words);
  DumpedBlock block{.name = fmt::format("device '{}'", device.name()), .bytes = copy_of(words.bytes()), .places = {}};
  name_words(block, [](std::size_t i) { return fmt::format("value {}", i); });
  return block;
}

/// The place of a byte; bytes between ports belong to no place.
DumpedBlock::Place place_of(const DumpedBlock& block, std::size_t byte) {
  for (const DumpedBlock::Place& place : block.places) {
    if (byte >= place.offset && byte < place.offset + place.size) return place;
  }
  return {"between two ports", byte, 1};
}

std::uint64_t word_at(const DumpedBlock& block, std::size_t offset, std::size_t size) {
  std::uint64_t word = 0;
  std::memcpy(&word, block.bytes.data() + offset, size);
  return word;
}

BitDifference difference_in(const DumpedBlock& a, const DumpedBlock& b, std::size_t byte) {
  const DumpedBlock::Place place = place_of(a, byte);
  BitDifference difference{.block = a.name, .place = place.name, .note = {}};
  difference.byte = (byte - place.offset) / 8 * 8;
  const std::size_t size = std::min<std::size_t>(8, place.size - difference.byte);
  difference.a = word_at(a, place.offset + difference.byte, size);
  difference.b = word_at(b, place.offset + difference.byte, size);
  difference.bit = std::countr_zero(difference.a ^ difference.b);
  return difference;
}

/// A scenario that is run again up to a cycle.
struct Resimulated {
  std::vector<DumpedBlock> blocks;
  bool reached = false;
  std::uint64_t digest = 0;
};

Result<std::unique_ptr<Session>> session_of(const record::Recording& recording, const device::ModelLibrary& models) {
  auto description = recorded_scenario(recording);
  if (!description) return std::unexpected(std::move(description.error()));
  return Session::create(std::move(*description), models);
}

Result<Resimulated> run_again(const record::Recording& recording, std::uint64_t cycle,
                              const device::ModelLibrary& models) {
  // Cycles are numbered from 0 and have a digest each: running again costs no more than the recorded run did.
  const std::size_t digests = recording.rows(recording.digest_topic());
  if (cycle >= digests) {
    return failure(Code::kIncompatible, {},
                   fmt::format("the recording names cycle {} and has {} digests", cycle, digests),
                   "Use a recording with all of its cycles");
  }
  auto session = session_of(recording, models);
  if (!session) return std::unexpected(std::move(session.error()));
  Resimulated again;
  RunOptions options;
  options.measure_times = false;
  options.repeat = false;
  options.keep_blocks = true;
  options.from = recorded_entry(recording);
  options.after_cycle = [&](BuiltCell& built) {
    again.reached = static_cast<std::uint64_t>(built.core->cycle()) > cycle;
    if (!again.reached) return true;
    again.digest = built.core->digest().value().low;
    again.blocks = dump_state(built);
    return false;
  };
  (void)(*session)->run(options);
  return again;
}

Result<Resimulated> run_with_its_models(const record::Recording& recording, std::uint64_t cycle,
                                        const device::ModelLibrary& otherwise) {
  const auto recorded = RecordedModels::unpack(recording);
  if (!recorded) return std::unexpected(recorded.error());
  return run_again(recording, cycle, *recorded ? (*recorded)->library() : otherwise);
}

/// The digest of a cycle as the recording has it.
std::optional<std::uint64_t> recorded_digest(const record::Recording& recording, std::uint64_t cycle) {
  record::DigestCursor cursor(recording);
  for (record::RecordedDigest digest; cursor.next(digest);)
    if (digest.cycle == cycle) return digest.digest;
  return std::nullopt;
}

void check_repeats(const record::Recording& recording, const Resimulated& again, std::uint64_t cycle, const char* side,
                   Diagnostics& diagnostics) {
  if (again.reached && recorded_digest(recording, cycle) == again.digest) return;
  diagnostics.error(Code::kIncompatible, side,
                    fmt::format("run again, this scenario is not the recorded run in cycle {}", cycle),
                    "Use the build and the back ends that it was recorded with, without interference");
}

}  // namespace

std::vector<DumpedBlock> dump_state(BuiltCell& built) {
  std::vector<DumpedBlock> blocks;
  rcc::ControlCore& core = *built.core;
  for (const rcc::Digest::BlockValue& value : core.digest().blocks()) {
    const auto id = static_cast<rcc::NetId>(value.block);
    if (value.block != 0 && value.block == id && core.net(id)) {
      blocks.push_back(dump_net(*core.net(id)));
    } else if (const device::Device* device = core.device_of_block(value.block)) {
      blocks.push_back(dump_device(*device));
    }
  }
  DumpedBlock world{.name = "simulation", .bytes = copy_of(built.world->state_bytes()), .places = {}};
  name_words(world, [&](std::size_t i) { return built.world->state_word_name(i); });
  blocks.push_back(std::move(world));
  return blocks;
}

std::optional<BitDifference> first_difference(const std::vector<DumpedBlock>& a, const std::vector<DumpedBlock>& b) {
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    if (i >= a.size() || i >= b.size() || a[i].name != b[i].name) {
      const auto name = [i](const auto& blocks) { return i < blocks.size() ? blocks[i].name : std::string("nothing"); };
      return BitDifference{.block = name(a), .place = {}, .note = fmt::format("{} against {}", name(a), name(b))};
    }
    if (a[i].bytes.size() != b[i].bytes.size()) {
      return BitDifference{.block = a[i].name,
                           .place = {},
                           .note = fmt::format("{} bytes against {}", a[i].bytes.size(), b[i].bytes.size())};
    }
    const auto [first, other] = std::ranges::mismatch(a[i].bytes, b[i].bytes);
    if (first != a[i].bytes.end()) {
      return difference_in(a[i], b[i], static_cast<std::size_t>(first - a[i].bytes.begin()));
    }
  }
  return std::nullopt;
}

std::string to_string(const BitDifference& difference) {
  if (!difference.note.empty()) return fmt::format("{}: {}", difference.block, difference.note);
  const std::string where = difference.byte == 0 ? "" : fmt::format(", byte {}", difference.byte);
  return fmt::format("{}, {}{}: bit {} ({:016x} against {:016x})", difference.block, difference.place, where,
                     difference.bit, difference.a, difference.b);
}

Result<std::optional<BitDifference>> find_bit(const record::Recording& a, const record::Recording& b,
                                              std::uint64_t cycle, const device::ModelLibrary& models) {
  const auto again_a = run_with_its_models(a, cycle, models);
  const auto again_b = run_with_its_models(b, cycle, models);
  Diagnostics diagnostics;
  if (!again_a) diagnostics.append(again_a.error());
  if (!again_b) diagnostics.append(again_b.error());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  check_repeats(a, *again_a, cycle, "A", diagnostics);
  check_repeats(b, *again_b, cycle, "B", diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return first_difference(again_a->blocks, again_b->blocks);
}

}  // namespace takt::cell
