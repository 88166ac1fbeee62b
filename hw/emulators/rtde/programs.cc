#include "hw/emulators/rtde/programs.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

constexpr std::size_t kMostSecondaries = 20;

}  // namespace

Programs::Programs(const urscript::Library& library, EventLog& events, std::function<void(int)> released)
    : library_(library), events_(events), released_(std::move(released)) {}

/// Reports what is wrong. @return null then
std::shared_ptr<const urscript::Program> Programs::compile(std::string_view text) {
  urscript::ScriptError error;
  auto program = urscript::compile(text, library_, error);
  if (program == nullptr) {
    add_event({.kind = ControllerEvent::Kind::kRuntimeException,
               .line = static_cast<std::uint32_t>(error.line),
               .column = static_cast<std::uint32_t>(error.column),
               .title = {},
               .text = error.text});
  }
  return program;
}

bool Programs::start(std::string_view text) {
  auto program = compile(text);
  if (program == nullptr) return false;
  if (program->secondary && secondaries_.size() >= kMostSecondaries) return false;
  const int first_thread = program->secondary ? kFirstSecondary : 1;
  auto machine = std::make_unique<urscript::Machine>(std::move(program), library_, first_thread);
  add_key("PROGRAM_XXX_STARTED", *machine);
  if (machine->program().secondary) {
    secondaries_.push_back(std::move(machine));
    return true;
  }
  end_main();
  main_ = std::move(machine);
  state_ = RuntimeState::kPlaying;
  return true;
}

Programs::Loading Programs::load(const std::string& path) {
  const auto at = installed.find(path);
  if (at == installed.end()) return Loading::kNotFound;
  if (compile(at->second) == nullptr) return Loading::kInvalid;
  stop();
  loaded_ = path;
  return Loading::kLoaded;
}

bool Programs::play() {
  if (state_ == RuntimeState::kPaused) return resume();
  if (running()) return true;
  const auto at = installed.find(loaded_);
  return at != installed.end() && start(at->second);
}

void Programs::pause() {
  if (state_ != RuntimeState::kPlaying) return;
  state_ = RuntimeState::kPaused;
  add_key("PROGRAM_XXX_PAUSED", *main_);
}

bool Programs::resume() {
  if (!running()) return false;
  if (state_ == RuntimeState::kPaused) add_key("PROGRAM_XXX_RESUMED", *main_);
  state_ = RuntimeState::kPlaying;
  for (Watchdog& watchdog : watchdogs_) watchdog.fed = now_;
  return true;
}

void Programs::stop() {
  if (in_frame_) {
    stop_asked_ = true;
    if (main_ != nullptr) main_->stop();
  } else {
    end_main();
  }
}

void Programs::end_main() {
  stop_asked_ = false;
  state_ = RuntimeState::kStopped;
  watchdogs_.clear();
  if (main_ == nullptr) return;
  report_end(*main_);
  main_.reset();
  released_(0);
}

void Programs::report_end(const urscript::Machine& machine) {
  if (const auto& error = machine.error()) {
    add_event({.kind = ControllerEvent::Kind::kRuntimeException,
               .line = static_cast<std::uint32_t>(error->line),
               .column = static_cast<std::uint32_t>(error->column),
               .title = {},
               .text = error->text});
  }
  add_key("PROGRAM_XXX_STOPPED", machine);
}

void Programs::set_watchdog(std::uint16_t field, Nanoseconds longest, WatchdogAction action) {
  std::erase_if(watchdogs_, [=](const Watchdog& watchdog) { return watchdog.field == field; });
  watchdogs_.push_back({field, longest, now_, action, false});
}

void Programs::fed(std::uint16_t field) {
  for (Watchdog& watchdog : watchdogs_) {
    if (watchdog.field != field) continue;
    watchdog.fed = now_;
    watchdog.barked = false;
  }
}

void Programs::check_watchdogs() {
  for (Watchdog& watchdog : watchdogs_) {
    if (watchdog.barked || now_ - watchdog.fed <= watchdog.longest) continue;
    watchdog.barked = true;
    add_event({.kind = ControllerEvent::Kind::kText,
               .title = {},
               .text = "RTDE input watchdog: the field was not written in time"});
    if (watchdog.action == WatchdogAction::kPause) pause();
    if (watchdog.action == WatchdogAction::kStop) return stop();
  }
}

void Programs::run_frame(Nanoseconds now, bool may_run) {
  now_ = now;
  if (running() && !may_run) pause();
  if (state_ == RuntimeState::kPlaying) check_watchdogs();
  in_frame_ = true;
  run_secondaries();
  if (state_ == RuntimeState::kPlaying) run_main();
  in_frame_ = false;
  if (stop_asked_ || (main_ != nullptr && main_->ended())) end_main();
}

void Programs::run_main() {
  (void)main_->run_frame();
  for (const int thread : main_->take_ended_threads()) released_(thread);
}

void Programs::run_secondaries() {
  for (const auto& machine : secondaries_)
    if (!machine->run_frame()) report_end(*machine);
  std::erase_if(secondaries_, [](const auto& machine) { return machine->ended(); });
}

void Programs::add_key(std::string_view title, const urscript::Machine& machine) {
  add_event({.kind = ControllerEvent::Kind::kKey, .title = std::string(title), .text = machine.program().name});
}

void Programs::add_event(ControllerEvent event) {
  event.time = now_;
  events_.add(std::move(event));
}

}  // namespace takt::hw::rtde
