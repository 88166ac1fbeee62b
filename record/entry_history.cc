#include "record/entry_history.h"

namespace takt::record {
namespace {

constexpr Nanoseconds kBlock = 200 * kMillisecond;
constexpr Nanoseconds kAfter = kSecond;  // what a fault leads to

}  // namespace

void EntryHistory::begin_cycle(Nanoseconds time) {
  now_ = time;
  if (now_ <= last_) return;
  if (blocks_.empty() || time - blocks_.back().begin >= kBlock) blocks_.push_back({.begin = time, .words = {}});
  // A block goes when the one behind it is old enough: at least the whole span stays.
  while (blocks_.size() > 1 && blocks_[1].begin <= now_ - span_) blocks_.pop_front();
}

void EntryHistory::add(const SampleRing::Entry& entry) {
  if (now_ <= last_) return take_(entry);
  if (blocks_.empty()) return;
  std::vector<std::uint64_t>& words = blocks_.back().words;
  words.push_back((std::uint64_t{entry.tag} << 32) | entry.words.size());
  words.insert(words.end(), entry.words.begin(), entry.words.end());
}

void EntryHistory::keep() {
  kept_ = true;
  for (const Block& block : blocks_) give(block);
  blocks_.clear();
  last_ = now_ + kAfter;
}

void EntryHistory::give(const Block& block) const {
  for (std::size_t at = 0; at < block.words.size();) {
    const std::size_t count = block.words[at] & 0xFFFFFFFF;
    take_({static_cast<std::uint32_t>(block.words[at] >> 32), {block.words.data() + at + 1, count}, true});
    at += count + 1;
  }
}

}  // namespace takt::record
