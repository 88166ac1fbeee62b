#include "core/rcc/digest.h"

#include <array>
#include <utility>

#include <fmt/format.h>
#include <xxhash.h>

namespace takt::rcc {

namespace {
constexpr std::uint64_t kFirstAdded = 1'000'000;  // numbers below it belong to the core: nets and devices
}

struct Digest::State {
  XXH3_state_t* xxh = XXH3_createState();
  State() { XXH3_128bits_reset(xxh); }
  ~State() { XXH3_freeState(xxh); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

Digest::Digest() : state_(std::make_unique<State>()) {}
Digest::~Digest() = default;

int Digest::add_block(std::string name, std::span<const std::byte> bytes) {
  blocks_.push_back({std::move(name), bytes});
  return static_cast<int>(blocks_.size()) - 1;
}

void Digest::keep_blocks(std::size_t capacity) {
  kept_.reserve(capacity);
  keeps_blocks_ = true;
}

const std::string* Digest::name_of(std::uint64_t block) const {
  const bool added = block >= kFirstAdded && block - kFirstAdded < blocks_.size();
  return added ? &blocks_[block - kFirstAdded].name : nullptr;
}

void Digest::take(std::uint64_t block, std::span<const std::byte> bytes) {
  const std::array<std::uint64_t, 2> header = {block, bytes.size()};
  XXH3_128bits_update(state_->xxh, header.data(), sizeof(header));
  XXH3_128bits_update(state_->xxh, bytes.data(), bytes.size());
  if (keeps_blocks_ && kept_.size() < kept_.capacity())
    kept_.push_back({.block = block, .value = XXH3_64bits(bytes.data(), bytes.size())});
}

void Digest::take_added_blocks() {
  for (std::size_t i = 0; i < blocks_.size(); ++i) take(kFirstAdded + i, blocks_[i].bytes);
}

Digest::Value Digest::value() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(state_->xxh);
  return {.high = hash.high64, .low = hash.low64};
}

std::string to_string(const Digest::Value& value) { return fmt::format("{:016x}{:016x}", value.high, value.low); }

}  // namespace takt::rcc
