#include "core/rcc/net_table.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace takt::rcc {

NetTable::NetTable(int capacity, net::Environment& environment, Bind bind)
    : slots_(static_cast<std::size_t>(capacity)),
      environment_(environment),
      bind_(std::move(bind)),
      retired_(static_cast<std::size_t>(capacity)) {}

NetTable::~NetTable() {
  worker_.request_stop();
  wake_.notify_all();
}

NetEntry* NetTable::find(NetId id) const {
  NetEntry* entry = slots_[id % slots_.size()].load(std::memory_order_acquire);
  return entry != nullptr && entry->id == id ? entry : nullptr;
}

NetEntry* NetTable::make_entry(const LoadOptions& options) {
  collect();
  const std::lock_guard lock(mutex_);
  for (std::size_t tried = 0; tried < slots_.size(); ++tried) {
    const NetId id = ++last_id_;
    auto& slot = slots_[id % slots_.size()];
    if (id == 0 || slot.load(std::memory_order_acquire) != nullptr) continue;
    auto entry = std::make_unique<NetEntry>();
    entry->id = id;
    entry->options = options;
    slot.store(entry.get(), std::memory_order_release);
    return entries_.emplace_back(std::move(entry)).get();
  }
  return nullptr;
}

void NetTable::compile(NetEntry& entry, const net::NetDescription& description) {
  const std::lock_guard lock(compile_mutex_);
  auto compiled = net::CompiledNet::compile(description, environment_);
  if (!compiled) {
    entry.findings = std::move(compiled.error());
    entry.state.store(NetState::kRejected, std::memory_order_release);
    return;
  }
  entry.net = std::move(*compiled);
  entry.findings = bind_(entry);
  const NetState state = entry.findings.has_errors() ? NetState::kRejected : NetState::kReady;
  entry.state.store(state, std::memory_order_release);
}

Result<NetId> NetTable::load(const net::NetDescription& description, const LoadOptions& options) {
  NetEntry* entry = make_entry(options);
  if (entry == nullptr)
    return failure("", fmt::format("no room for another net ({} are loaded)", slots_.size()), "unload some first");
  compile(*entry, description);
  if (entry->state == NetState::kReady) return entry->id;
  Findings findings = std::move(entry->findings);
  retire(*entry);
  collect();
  return std::unexpected(std::move(findings));
}

NetId NetTable::load_async(net::NetDescription description, const LoadOptions& options) {
  NetEntry* entry = make_entry(options);
  if (entry == nullptr) return 0;
  const std::lock_guard lock(mutex_);
  jobs_.push_back({entry, std::move(description)});
  if (!worker_.joinable()) worker_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  wake_.notify_one();
  return entry->id;
}

void NetTable::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::unique_lock lock(mutex_);
    if (!wake_.wait(lock, stop, [this] { return !jobs_.empty(); })) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    compile(*job.entry, job.description);
  }
}

std::pair<std::string, std::string> NetTable::where_it_is(NetId id) {
  const std::lock_guard lock(mutex_);  // so that nobody frees the net meanwhile
  const NetEntry* entry = find(id);
  if (entry == nullptr || entry->net == nullptr) return {};
  return {entry->net->name(), std::string(entry->net->progress())};
}

void NetTable::retire(NetEntry& entry) {
  auto& slot = slots_[entry.id % slots_.size()];
  // The order matters: while the slot is taken nobody else gets this place, so `retired_` there is free.
  retired_[entry.id % slots_.size()].store(&entry, std::memory_order_release);
  slot.store(nullptr, std::memory_order_release);
}

void NetTable::collect() {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [this](const std::unique_ptr<NetEntry>& entry) {
    auto& retired = retired_[entry->id % retired_.size()];
    if (retired.load(std::memory_order_acquire) != entry.get()) return false;
    retired.store(nullptr, std::memory_order_release);
    return true;
  });
}

}  // namespace takt::rcc
