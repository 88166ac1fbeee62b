#include "serve/hosted_cell.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <utility>

namespace takt::serve {
namespace {

constexpr std::size_t kMostOrders = 64;
constexpr Nanoseconds kSettling = 5 * kSecond;  // any arm comes to rest in less

}  // namespace

Result<std::unique_ptr<HostedCell>> HostedCell::open(const std::filesystem::path& file,
                                                     const device::ModelLibrary& models, const Options& options) {
  Diagnostics diagnostics;
  auto description =
      cell::read_description(file, options.open.overrides, options.open.seed, diagnostics, cell::ReadFor::kCell);
  if (diagnostics.has_errors() && description) diagnostics.append(check_cell_names(*description, models));
  diagnostics.set_file(file.string());
  if (diagnostics.has_errors() || !description) return std::unexpected(std::move(diagnostics));
  description->site = options.open.site;
  description->realtime = options.run.realtime;
  Diagnostics warnings = std::move(diagnostics);
  auto built = cell::build_cell(*description, models, options.open.measure_times, warnings);
  if (!built) {
    built.error().set_file(file.string());
    return std::unexpected(std::move(built.error()));
  }
  auto faults = cell::make_faults(description->faults, *built);
  if (!faults) {
    faults.error().set_file(file.string());
    return std::unexpected(std::move(faults.error()));
  }
  warnings.set_file(file.string());
  return std::unique_ptr<HostedCell>(
      new HostedCell(std::move(*description), std::move(*built), std::move(*faults), std::move(warnings), options));
}

HostedCell::HostedCell(cell::Description description, cell::BuiltCell built, std::vector<cell::ScheduledFault> faults,
                       Diagnostics warnings, const Options& options)
    : options_(options),
      description_(std::move(description)),
      built_(std::move(built)),
      faults_(std::move(faults)),
      warnings_(std::move(warnings)),
      lease_(*built_.core) {
  run_.emplace(description_, built_, no_expectations_, faults_, options_.run);
  add_jog_channels();
  for (const auto& [name, arm] : built_.cell.arms) fresh_.arms.push_back({.name = name});
  for (const auto& [name, channel] : built_.cell.channels) fresh_.channels.push_back({.name = name});
  copy({});
  publish();
}

HostedCell::~HostedCell() = default;

void HostedCell::add_jog_channels() {
  const auto add = [this](const std::string& name, net::ValueType type, std::string unit) {
    auto made = device::Channel::make({.name = name, .type = type, .unit = std::move(unit)});
    if (!made) throw std::logic_error(made.error().to_string());
    device::Channel* channel = made->get();
    built_.core->add(name, std::unique_ptr<net::Resource>(std::move(*made)));
    return channel;
  };
  for (const auto& [name, arm] : built_.cell.arms)
    jog_channels_[name] = {.tool = add("jog/" + name + "/tool", net::ValueType::kTwist, "m/s,rad/s"),
                           .joints = add("jog/" + name + "/joints", net::ValueType::kJoints, "rad/s")};
}

void HostedCell::begin_cycle() {
  const rcc::ControlCore& core = *built_.core;
  for (const auto& [name, channels] : jog_channels_) {
    channels.tool->begin_cycle(core.cycle(), core.time());
    channels.joints->begin_cycle(core.cycle(), core.time());
  }
}

bool HostedCell::interrupted() const { return options_.run.interrupt != nullptr && options_.run.interrupt->load() > 0; }

void HostedCell::stop() {
  const std::lock_guard lock(mutex_);
  stop_asked_ = true;
  wake_.notify_all();
}

CellView HostedCell::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

HostedCell::Events HostedCell::events_from(std::int64_t sequence, std::size_t most) const {
  const std::lock_guard lock(mutex_);
  Events found;
  const std::int64_t first = next_sequence_ - static_cast<std::int64_t>(log_.size());
  found.lost = sequence < first;
  const std::int64_t from = std::max(sequence, first);
  for (std::int64_t one = from; one < next_sequence_ && found.events.size() < most; ++one)
    found.events.push_back(log_[static_cast<std::size_t>(one - first)]);
  found.next = from + static_cast<std::int64_t>(found.events.size());
  return found;
}

std::int64_t HostedCell::next_event() const {
  const std::lock_guard lock(mutex_);
  return next_sequence_;
}

void HostedCell::on_news(std::function<void()> listener) {
  const std::lock_guard lock(listener_mutex_);
  listener_ = std::move(listener);
}

bool HostedCell::steps(std::int64_t cycles, std::function<void(const CellView& view)> done) {
  if (realtime()) return false;
  const std::lock_guard lock(mutex_);
  if (orders_.size() >= kMostOrders || stop_asked_) return false;
  orders_.push_back({cycles, std::move(done)});
  wake_.notify_all();
  return true;
}

/// Between two cycles. Realtime loop: under its lock, so that it only copies.
void HostedCell::copy(std::span<const rcc::Event> events) {
  rcc::ControlCore& core = *built_.core;
  fresh_.cycle = core.cycle();
  fresh_.time = core.time();
  fresh_.digest = core.digest().value();
  fresh_.connected = connected_;
  for (ArmView& view : fresh_.arms) {
    const device::Arm& arm = *built_.cell.arms.at(view.name).device;
    if (arm.has_sample()) {
      const device::ArmSample& sample = arm.sample();
      view.q_measured = sample.q;
      view.dq_measured = sample.dq;
      view.tau_measured = sample.tau;
      view.fault = sample.fault;
    }
    view.q_commanded = arm.set_point().q;
    view.mode = arm.mode();
    view.ready = arm.ready();
    view.at_rest = arm.at_rest();
    view.held = arm.held();
  }
  for (CellView::Channel& view : fresh_.channels) {
    const device::Channel& channel = *built_.cell.channels.at(view.name);
    view.value = device::value_in(channel.description().type, channel.raw_slot());
    view.age = channel.age();
  }
  cell::copy_picture_state(*built_.world, fresh_.picture);
  for (const rcc::Event& event : events)
    fresh_events_.push_back(
        {.sequence = 0, .cycle = event.cause.cycle >= 0 ? event.cause.cycle : core.cycle() - 1, .event = event});
}

/// Outside of the loop's lock.
void HostedCell::publish() {
  {
    const std::lock_guard lock(mutex_);
    view_ = fresh_;
    for (LoggedEvent& event : fresh_events_) {
      event.sequence = next_sequence_++;
      log_.push_back(std::move(event));
      if (log_.size() > kEvents) log_.pop_front();
    }
    fresh_events_.clear();
  }
  const std::lock_guard lock(listener_mutex_);
  if (listener_) listener_();
}

bool HostedCell::clear() const {
  return std::ranges::all_of(
      built_.cell.arms, [](const auto& one) { return one.second.device->at_rest() && !one.second.device->held(); });
}

/// Every arm has one to begin from.
bool HostedCell::have_set_points() const {
  return std::ranges::all_of(built_.cell.arms,
                             [](const auto& one) { return one.second.device->set_point().q.size() > 0; });
}

cell::RunReport HostedCell::run() {
  if (run_->open()) {
    realtime() ? run_realtime() : run_lockstep();
  } else {
    failed_ = true;
  }
  // Whoever waits for steps is answered with where the cell is.
  std::deque<Order> left;
  {
    const std::lock_guard lock(mutex_);
    stop_asked_ = true;
    left.swap(orders_);
  }
  for (const Order& order : left) order.done(view());
  return run_->finish(false, {});
}

bool HostedCell::cycle_lockstep() {
  begin_cycle();
  const bool going = run_->step({});
  lease_.after_cycle();
  copy(built_.core->events());
  if (!going) failed_ = true;
  return going;
}

void HostedCell::run_lockstep() {
  connected_ = run_->connect([this] { return end_asked(); });
  while (connected_ && !have_set_points())
    if (!cycle_lockstep()) break;
  copy({});
  publish();
  while (connected_ && !failed_) {
    Order order;
    {
      std::unique_lock lock(mutex_);
      // A signal handler cannot wake it.
      wake_.wait_for(lock, std::chrono::milliseconds(50), [this] { return stop_asked_ || !orders_.empty(); });
      if (end_asked()) break;
      if (orders_.empty()) continue;
      order = std::move(orders_.front());
      orders_.pop_front();
    }
    for (std::int64_t i = 0; i < order.cycles && !end_asked() && cycle_lockstep(); ++i)
      if (fresh_events_.size() >= 64) publish();
    publish();
    order.done(fresh_);
  }
  settle_lockstep();
}

void HostedCell::settle_lockstep() {
  (void)lease_.release(lease_.holder());
  const Nanoseconds until = built_.core->time() + kSettling;
  while (connected_ && !failed_ && !clear() && built_.core->time() < until)
    if (!cycle_lockstep()) break;
  publish();
}

void HostedCell::run_realtime() {
  const auto loop = cell::realtime_loop(built_, options_.run);
  run_->before_cycle();  // of the first one
  begin_cycle();
  Nanoseconds until = 0;
  const auto program = [&] {
    copy(*loop->support().events);
    if (!run_->look_on({})) {
      failed_ = true;
      return false;
    }
    if (!connected_ && !end_asked()) {
      const auto connection = run_->look_for_devices();
      failed_ = connection == cell::CellRun::Connection::kFailed;
      connected_ = connection == cell::CellRun::Connection::kThere && have_set_points();
      return !failed_;
    }
    if (!end_asked()) return true;
    if (until == 0) {
      (void)lease_.release(lease_.holder());
      until = built_.core->time() + kSettling;
    }
    return !clear() && built_.core->time() < until;
  };
  const auto report = loop->run({.after_cycle =
                                     [this] {
                                       const bool going = run_->after_cycle();
                                       lease_.after_cycle();
                                       run_->before_cycle();  // of the next one
                                       begin_cycle();
                                       return going;
                                     },
                                 .program = program,
                                 .outside = [this] { publish(); }});
  run_->in_realtime(report);
  publish();
}

}  // namespace takt::serve
