#include "core/rcc/net_table.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/last_catch.h"

namespace takt::rcc {

void NetEntry::bind_flags(Diagnostics& wrong) {
  for (const auto& [name, flag] : {std::pair(&options.goes_on, &goes_on), std::pair(&options.stopped, &stopped)}) {
    if (name->empty()) continue;
    *flag = net->find<net::Boolean>(*name);
    if (*flag == nullptr)
      wrong.error(Code::kUnknownName, name == &options.stopped ? "/stopped" : "/goes_on",
                  fmt::format("the net has no Boolean output '{}'", *name), "Name an output of the net, \"id.port\"");
  }
}

NetTable::NetTable(int capacity, net::Environment& environment, Bind bind)
    : slots_(static_cast<std::size_t>(capacity)),
      aborts_(slots_.size()),
      retirements_(slots_.size()),
      environment_(environment),
      bind_(std::move(bind)) {}

NetTable::~NetTable() {
  worker_.request_stop();
  wake_.notify_all();
}

NetEntry* NetTable::find(NetId id) const {
  NetEntry* entry = slots_[slot_of(id)].entry.load(std::memory_order_acquire);
  return entry != nullptr && entry->id == id ? entry : nullptr;
}

std::shared_ptr<NetEntry> NetTable::share(NetId id) const {
  // In one order that all threads agree on, either `looking` is counted before collect() reads it, and the entry stays,
  // or the slot is empty by now: take_retired() has emptied it before collect() looks.
  const Slot& slot = slots_[slot_of(id)];
  slot.looking.fetch_add(1, std::memory_order_seq_cst);
  NetEntry* entry = slot.entry.load(std::memory_order_seq_cst);
  std::shared_ptr<NetEntry> handle = entry != nullptr && entry->id == id ? entry->shared_from_this() : nullptr;
  slot.looking.fetch_sub(1, std::memory_order_seq_cst);
  return handle;
}

bool NetTable::ask_abort(NetId id) {
  const std::shared_ptr<NetEntry> entry = share(id);
  if (entry == nullptr) return false;
  // The flag names the net, the bit only says where to look: the slot may be another net's by then.
  entry->abort_asked.store(true, std::memory_order_release);
  aborts_.set(slot_of(id));
  return true;
}

bool NetTable::ask_retire(NetId id) {
  const std::shared_ptr<NetEntry> entry = share(id);
  if (entry == nullptr) return false;
  entry->retire_asked.store(true, std::memory_order_release);
  retirements_.set(slot_of(id));
  return true;
}

void NetTable::take_retired() {
  retirements_.take([this](std::size_t place) {
    Slot& slot = slots_[place];
    NetEntry* entry = slot.entry.load(std::memory_order_acquire);
    if (entry == nullptr || !entry->retire_asked.load(std::memory_order_acquire)) return;
    // A start in the cycle in which it was asked for came first: it is forgotten when it has ended.
    if (is_active(entry->state.load(std::memory_order_acquire))) return retirements_.set(place);
    slot.entry.store(nullptr, std::memory_order_seq_cst);
    slot.retired.store(entry, std::memory_order_release);  // last: from now on collect() may free it
  });
}

std::shared_ptr<NetEntry> NetTable::reserve(const LoadOptions& options) {
  collect();
  const std::lock_guard lock(mutex_);
  for (std::size_t tried = 0; tried < slots_.size(); ++tried) {
    const NetId id = ++last_id_;
    Slot& slot = slots_[slot_of(id)];
    if (id == 0 || slot.taken) continue;
    slot.taken = true;
    auto entry = std::make_shared<NetEntry>();
    entry->id = id;
    entry->options = options;
    return entries_.emplace_back(std::move(entry));
  }
  return nullptr;
}

void NetTable::publish(NetEntry& entry) { slots_[slot_of(entry.id)].entry.store(&entry, std::memory_order_seq_cst); }

void NetTable::drop(const std::shared_ptr<NetEntry>& entry) {
  const std::lock_guard lock(mutex_);
  std::erase(entries_, entry);
  slots_[slot_of(entry->id)].taken = false;
}

void NetTable::collect() {
  std::vector<std::shared_ptr<NetEntry>> freed;  // outlives the lock: a large net takes its time to be destroyed
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const std::shared_ptr<NetEntry>& entry) {
    Slot& slot = slots_[slot_of(entry->id)];
    const bool let_go = slot.retired.load(std::memory_order_acquire) == entry.get();
    if (!let_go || slot.looking.load(std::memory_order_seq_cst) != 0) return false;
    slot.retired.store(nullptr, std::memory_order_relaxed);
    slot.taken = false;
    freed.push_back(entry);
    return true;
  });
}

/// Whatever happens meanwhile, the net is Ready or Rejected afterwards: nobody waits for it for ever.
void NetTable::compile(NetEntry& entry, const net::NetDescription& description) noexcept {
  if (!run_caught("compile a net", [&] { compile_or_throw(entry, description); }))
    entry.state.store(NetState::kRejected, std::memory_order_release);
}

void NetTable::compile_or_throw(NetEntry& entry, const net::NetDescription& description) {
  const std::lock_guard lock(compile_mutex_);
  try {
    auto compiled = net::CompiledNet::compile(description, environment_);
    if (compiled) entry.net = std::move(*compiled);
    entry.diagnostics = compiled ? bind_(entry) : std::move(compiled.error());
  } catch (...) {
    // Of a plug-in, most likely: the net is refused like any other that cannot be.
    entry.diagnostics.error(
        Code::kInternal, "", fmt::format("internal: {}", exception_text()),
        fmt::format("Report it: this happened while net {} ('{}') was loaded", entry.id, description.name));
  }
  const NetState state = entry.diagnostics.has_errors() ? NetState::kRejected : NetState::kReady;
  entry.state.store(state, std::memory_order_release);
}

Result<NetId> NetTable::load(const net::NetDescription& description, const LoadOptions& options) {
  const std::shared_ptr<NetEntry> entry = reserve(options);
  if (entry == nullptr)
    return failure(Code::kTooLarge, "", fmt::format("no room for another net ({} are loaded)", slots_.size()),
                   "Unload some first");
  compile(*entry, description);
  if (entry->state == NetState::kReady) {
    publish(*entry);
    return entry->id;
  }
  drop(entry);
  return std::unexpected(std::move(entry->diagnostics));
}

NetId NetTable::load_async(net::NetDescription description, const LoadOptions& options) {
  const std::shared_ptr<NetEntry> entry = reserve(options);
  if (entry == nullptr) return 0;
  publish(*entry);
  const std::lock_guard lock(mutex_);
  jobs_.push_back({entry, std::move(description)});
  try {
    if (!worker_.joinable()) worker_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  } catch (const std::system_error& error) {
    // No thread can be had: the net is compiled by nobody.
    jobs_.pop_back();
    entry->diagnostics.error(Code::kSystem, "", fmt::format("no thread to load net {}: {}", entry->id, error.what()),
                             "Load it with load()");
    entry->state.store(NetState::kRejected, std::memory_order_release);
  }
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

}  // namespace takt::rcc
