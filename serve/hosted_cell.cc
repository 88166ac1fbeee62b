#include "serve/hosted_cell.h"

#include <algorithm>
#include <span>
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
      warnings_(std::move(warnings)) {
  run_.emplace(description_, built_, no_expectations_, faults_, options_.run);
  begin(description_, built_);
  add_jog_channels();
}

HostedCell::~HostedCell() = default;

bool HostedCell::interrupted() const { return options_.run.interrupt != nullptr && options_.run.interrupt->load() > 0; }

void HostedCell::stop() {
  const std::lock_guard lock(mutex_);
  stop_asked_ = true;
  wake_.notify_all();
}

bool HostedCell::steps(std::int64_t cycles, std::function<void(const CellView& view)> done) {
  if (realtime()) return false;
  const std::lock_guard lock(mutex_);
  if (orders_.size() >= kMostOrders || stop_asked_) return false;
  orders_.push_back({cycles, std::move(done)});
  wake_.notify_all();
  return true;
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
  begin_jog_channels();
  const bool going = run_->step({});
  lease().after_cycle();
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
      if (unpublished() >= 64) publish();
    publish();
    order.done(fresh());
  }
  settle_lockstep();
}

void HostedCell::settle_lockstep() {
  (void)lease().release(lease().holder());
  const Nanoseconds until = built_.core->time() + kSettling;
  while (connected_ && !failed_ && !clear() && built_.core->time() < until)
    if (!cycle_lockstep()) break;
  publish();
}

void HostedCell::run_realtime() {
  const auto loop = cell::realtime_loop(built_, options_.run);
  run_->before_cycle();  // of the first one
  begin_jog_channels();
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
      (void)lease().release(lease().holder());
      until = built_.core->time() + kSettling;
    }
    return !clear() && built_.core->time() < until;
  };
  const auto report = loop->run({.after_cycle =
                                     [this] {
                                       const bool going = run_->after_cycle();
                                       lease().after_cycle();
                                       run_->before_cycle();  // of the next one
                                       begin_jog_channels();
                                       return going;
                                     },
                                 .program = program,
                                 .outside = [this] { publish(); }});
  run_->in_realtime(report);
  publish();
}

}  // namespace takt::serve
