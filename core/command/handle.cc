#include "core/command/handle.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "core/command/external_watch.h"
#include "core/command/mapping.h"
#include "core/command/motion_action.h"
#include "core/device/channel.h"

namespace takt::command {
namespace {

/// Values a watch keeps for a program that looks late.
constexpr int kWatchCapacity = 64;
/// Traced ports of one command: the core has room for a number of watches only.
constexpr std::size_t kMostTraced = 24;

std::string text_of(const std::optional<device::ChannelValue>& value) {
  return value ? device::to_text(*value) : "null";
}

}  // namespace

struct Runtime::Impl {
  rcc::ControlCore& core;
  std::function<void()> step;
  std::vector<std::weak_ptr<CommandHandle::Impl>> handles;

  void poll();
};

struct CommandHandle::Impl {
  std::shared_ptr<Runtime::Impl> runtime;
  rcc::NetId id = 0;
  std::map<std::string, std::string> observed;
  ExternalWatch externals;
  std::vector<std::pair<std::string, std::shared_ptr<rcc::Watch>>> traced;
  /// By cycle, the newest; text is made of them only when somebody asks.
  std::map<std::int64_t, std::vector<std::pair<const std::string*, std::optional<device::ChannelValue>>>> trace;
  rcc::RequestId request = 0;
  std::optional<net::Cause> refused;
  bool begun = false, called_off = false;
  bool wants_start = false, wants_cancel = false;  ///< not posted yet: the core's queue was full

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl();

  [[nodiscard]] rcc::ControlCore& core() const { return runtime->core; }
  Findings attach(const MappedCommand& mapped);
  void poll();
  void ask();
  /// @return true if it will not begin: it was not started, or its start was not posted yet
  bool call_off();
  void note_trace();
};

CommandHandle::Impl::~Impl() {
  if (id == 0) return;
  for (auto& [name, watch] : traced) core().unwatch(watch);
  externals.detach();
  (void)core().unload(id);
}

/// @return findings where there is no room to hear of an external effect: none is lost in silence
Findings CommandHandle::Impl::attach(const MappedCommand& mapped) {
  observed = mapped.observed;
  Findings lost = externals.attach(core(), id, mapped.externals);
  const rcc::WatchOptions all{.every = 1, .capacity = kWatchCapacity};
  for (const TracedPort& port : mapped.traced) {
    if (traced.size() == kMostTraced) break;
    if (auto watch = core().watch(id, port.port, all)) traced.emplace_back(port.name, std::move(*watch));
  }
  return lost;
}

void CommandHandle::Impl::note_trace() {
  std::array<rcc::WatchedValue, kWatchCapacity> values;
  for (auto& [name, watch] : traced) {
    const std::size_t taken = watch->take(values);
    for (std::size_t i = taken > kTracedCycles ? taken - kTracedCycles : 0; i < taken; ++i) {
      trace[values[i].cycle].emplace_back(&name, values[i].value);
    }
  }
  while (trace.size() > kTracedCycles) trace.erase(trace.begin());
}

/// Posts what is wanted; what finds no room is posted again after the next cycle.
void CommandHandle::Impl::ask() {
  if (wants_start) request = core().start(id);
  wants_start = wants_start && request == 0;
  wants_cancel = wants_cancel && core().cancel(id) == 0;
}

void CommandHandle::Impl::poll() {
  ask();
  for (const rcc::Event& event : core().events()) {
    if (event.kind != rcc::Event::Kind::kRefused || request == 0 || event.request != request) continue;
    refused = net::Cause{net::Cause::Code::kError, event.cause.text, core().cycle() - 1};
  }
  externals.poll();
  note_trace();
}

void Runtime::Impl::poll() {
  std::erase_if(handles, [](const auto& handle) { return handle.expired(); });
  const auto all = handles;  // a handler may load another command
  for (const auto& one : all) {
    if (const auto handle = one.lock()) handle->poll();
  }
}

bool CommandStatus::succeeded() const {
  return ended() && (cause.code == net::Cause::Code::kTerminated || cause.code == net::Cause::Code::kCancelled);
}

std::string CommandStatus::to_string() const {
  std::string text = fmt::format("{} in cycle {}: {}", net::name_of(cause.code), last_cycle, cause.text.view());
  for (const TracedCycle& one : last_cycles) {
    text += fmt::format("\n  {}:", one.cycle);
    for (const auto& [name, value] : one.values) text += fmt::format(" {}={}", name, value);
  }
  return text;
}

void CommandHandle::start() {
  if (impl_->called_off || impl_->begun) return;
  impl_->begun = impl_->wants_start = true;
  impl_->ask();
}

Findings CommandHandle::schedule_after(const CommandHandle& predecessor, const CommandHandle* from_rest) {
  Findings findings;
  if (impl_->begun || impl_->called_off) {
    findings.error({}, impl_->begun ? "C5: this command was started already" : "this command was cancelled already",
                   "load() of a new command: each runs once at most");
  }
  for (const CommandHandle* other : {&predecessor, from_rest}) {
    if (other && other->impl_->runtime != impl_->runtime)
      findings.error({}, "the two commands belong to different runtimes", "commands of one Runtime");
  }
  if (predecessor.impl_ == impl_) findings.error({}, "C5: this command is to follow itself", "another command");
  if (findings.has_errors()) return findings;
  auto request = impl_->core().schedule_after(predecessor.net(), impl_->id, from_rest ? from_rest->net() : 0);
  if (!request) return std::move(request.error());
  impl_->request = *request;
  impl_->begun = true;
  return findings;
}

bool CommandHandle::Impl::call_off() {
  called_off = called_off || !begun || std::exchange(wants_start, false);
  return called_off;
}

void CommandHandle::cancel() {
  if (impl_->call_off()) return;
  impl_->wants_cancel = true;
  impl_->ask();
}

void CommandHandle::abort() {
  if (!impl_->call_off()) impl_->core().abort(impl_->id);
}

CommandStatus CommandHandle::wait(std::int64_t most_cycles) {
  CommandStatus now = status();
  for (std::int64_t i = 0; i < most_cycles && !now.ended(); ++i) {
    impl_->runtime->step();
    impl_->runtime->poll();
    now = status();
  }
  return now;
}

CommandStatus CommandHandle::status() const {
  const rcc::NetStatus net = impl_->core().status(impl_->id);
  CommandStatus status{.state = net.state,
                       .cause = net.cause,
                       .first_cycle = net.first_cycle,
                       .last_cycle = net.last_cycle,
                       .last_cycles = {}};
  if (impl_->refused) {
    status.state = rcc::NetState::kTerminated;
    status.cause = *impl_->refused;
    status.last_cycle = impl_->refused->cycle;
  } else if (impl_->called_off) {
    status.state = rcc::NetState::kTerminated;
    status.cause.code = net::Cause::Code::kCancelled;
  }
  if (status.ended() && !status.succeeded()) {
    for (const auto& [cycle, values] : impl_->trace) {
      TracedCycle& told = status.last_cycles.emplace_back(TracedCycle{.cycle = cycle, .values = {}});
      for (const auto& [name, value] : values) told.values.emplace_back(*name, text_of(value));
    }
  }
  return status;
}

template <class T>
std::optional<T> CommandHandle::value(const std::string& name) const {
  const auto port = impl_->observed.find(name);
  const rcc::NetHandle net = impl_->core().net(impl_->id);
  if (port == impl_->observed.end() || net == nullptr) return std::nullopt;
  const auto* slot = net->template find<T>(port->second);
  return slot == nullptr || slot->null != 0 ? std::nullopt : std::optional<T>(slot->value);
}

template std::optional<net::Boolean> CommandHandle::value(const std::string&) const;
template std::optional<net::Integer> CommandHandle::value(const std::string&) const;
template std::optional<net::Real> CommandHandle::value(const std::string&) const;
template std::optional<net::Vector> CommandHandle::value(const std::string&) const;
template std::optional<net::Frame> CommandHandle::value(const std::string&) const;
template std::optional<net::Twist> CommandHandle::value(const std::string&) const;
template std::optional<net::Wrench> CommandHandle::value(const std::string&) const;
template std::optional<net::JointArray> CommandHandle::value(const std::string&) const;

rcc::NetId CommandHandle::net() const { return impl_->id; }
std::int64_t CommandHandle::external_times_lost() const { return impl_->externals.times_lost(); }
void CommandHandle::poll() { impl_->poll(); }

Runtime::Runtime(rcc::ControlCore& core, std::function<void()> step)
    : impl_(std::make_shared<Impl>(Impl{core, std::move(step), {}})) {
  if (!impl_->step) impl_->step = [&core] { core.step(); };
}

Result<CommandHandle> Runtime::load(const Command& command) {
  Findings findings = plan(command);
  if (findings.has_errors()) return std::unexpected(std::move(findings));
  auto mapped = map(command, impl_->core.period());
  if (!mapped) return std::unexpected(std::move(mapped.error()));
  auto id = impl_->core.load(mapped->net, mapped->options);
  if (!id) return std::unexpected(std::move(id.error()));
  auto handle = std::make_shared<CommandHandle::Impl>();
  handle->runtime = impl_;
  handle->id = *id;
  if (Findings lost = handle->attach(*mapped); lost.has_errors()) return std::unexpected(std::move(lost));
  impl_->handles.push_back(handle);
  return CommandHandle(std::move(handle));
}

CommandStatus Runtime::execute(const Command& command) {
  auto handle = load(command);
  if (handle) {
    handle->start();
    return handle->wait();
  }
  CommandStatus status;
  status.state = rcc::NetState::kRejected;
  status.cause.code = net::Cause::Code::kError;
  status.cause.text = net::Text(handle.error().to_string());
  return status;
}

void Runtime::step() {
  impl_->step();
  impl_->poll();
}
void Runtime::poll() { impl_->poll(); }
rcc::ControlCore& Runtime::core() { return impl_->core; }

}  // namespace takt::command
