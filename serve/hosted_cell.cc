#include "serve/hosted_cell.h"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "cell/judge/expectations.h"

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
      recordings_(description_, built_, options_.run, options_.recordings) {
  // As of a program in C++: nobody knows its steps.
  auto expectations = cell::make_expectations(description_.expectations, built_, std::nullopt);
  if (expectations) {
    expectations_ = std::move(*expectations);
  } else {
    warnings_.append(expectations.error());
  }
  run_.emplace(description_, built_, expectations_, faults_, options_.run);
  run_->ask_touching([this] {
    constexpr std::int64_t kMoment = 200;  // cycles
    auto all = touching_;
    if (realtime() && built_.core->cycle() - touching_since_ < kMoment) all.insert(touched_.begin(), touched_.end());
    return all;
  });
  begin(description_, built_);
  follow_.emplace(built_, lease());
  add_jog_channels();
}

HostedCell::~HostedCell() = default;

void HostedCell::begin_cycle() {
  begin_jog_channels();
  if (stop_nets_.load(std::memory_order_acquire)) {
    const net::Text why = stop_why_;
    stop_nets_.store(false, std::memory_order_release);
    built_.core->stop_all(net::Cause::Code::kAborted, why.view());
    follow_->before_cycle();
    follow_->stopped(why);
    return;
  }
  follow_->before_cycle();
}

void HostedCell::stop_all(const std::string& by) { stop_nets(net::Text(fmt::format("STOP by '{}'", by))); }

void HostedCell::stop_nets(const net::Text& why) {
  if (stop_nets_.load(std::memory_order_acquire)) return;  // the cycle that comes next stops them
  stop_why_ = why;
  stop_nets_.store(true, std::memory_order_release);
}

void HostedCell::between_cycles(std::function<void(cell::CellRun& run)> task) {
  const std::lock_guard lock(mutex_);
  tasks_.push_back(std::move(task));
  wake_.notify_all();
}

void HostedCell::set_touching(std::set<std::string, std::less<>> devices) {
  touched_ = std::exchange(touching_, std::move(devices));
  touching_since_ = built_.core->cycle();
}

void HostedCell::wake() {
  const std::lock_guard lock(mutex_);
  woken_ = true;
  wake_.notify_all();
}

void HostedCell::do_tasks() {
  std::vector<std::function<void(cell::CellRun & run)>> tasks;
  {
    const std::lock_guard lock(mutex_);
    tasks.swap(tasks_);
  }
  for (const auto& task : tasks) task(*run_);
}

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
  recordings_.close();
  return run_->finish(false, {});
}

bool HostedCell::cycle_lockstep() {
  begin_cycle();
  const bool going = run_->step({});
  follow_->after_cycle();
  recordings_.after_cycle();
  lease().after_cycle();
  recordings_.between_cycles(built_.core->events());
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
      wake_.wait_for(lock, std::chrono::milliseconds(50),
                     [this] { return stop_asked_ || woken_ || !tasks_.empty() || !orders_.empty(); });
      if (end_asked()) break;
      if (woken_ || !tasks_.empty() || orders_.empty()) {
        woken_ = false;
        lock.unlock();
        look_around();
        continue;
      }
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

/// While no cycle runs: what else there is to do.
void HostedCell::look_around() {
  recordings_.between_cycles({});
  follow_->look();
  do_tasks();
  tell_listener();
}

void HostedCell::settle_lockstep() {
  lease().release_all();
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
    recordings_.between_cycles(*loop->support().events);
    copy(*loop->support().events);
    follow_->look();
    do_tasks();
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
      lease().release_all();
      until = built_.core->time() + kSettling;
    }
    return !clear() && built_.core->time() < until;
  };
  const auto report = loop->run({.after_cycle =
                                     [this] {
                                       const bool going = run_->after_cycle();
                                       follow_->after_cycle();
                                       recordings_.after_cycle();
                                       lease().after_cycle();
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
