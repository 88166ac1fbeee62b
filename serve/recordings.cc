#include "serve/recordings.h"

#include <chrono>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "cell/judge/run_log.h"
#include "cell/run/run_recorder.h"
#include "core/net/primitive.h"

namespace takt::serve {
namespace {

using namespace std::chrono_literals;

Diagnostics refused(std::string message, std::string hint) {
  Diagnostics why;
  why.error(Code::kNotPossibleNow, "/state", std::move(message), std::move(hint));
  return why;
}

}  // namespace

std::string_view name_of(Recordings::State state) {
  switch (state) {
    case Recordings::State::kOff:
      return "off";
    case Recordings::State::kOn:
      return "on";
    case Recordings::State::kLast:
      return "last";
  }
  return "";
}

Recordings::Recordings(const cell::Description& description, const cell::BuiltCell& built, const cell::RunOptions& run,
                       std::filesystem::path folder)
    : description_(description), built_(built), run_(run), folder_(std::move(folder)) {}

Recordings::~Recordings() = default;

Diagnostics Recordings::refusal() const {
  if (folder_.empty())
    return refused("this server makes no recordings", "Start it with takt serve --recordings FOLDER");
  const std::lock_guard lock(mutex_);
  return closed_ ? refused("the cell has ended", "Start the server again") : Diagnostics();
}

Diagnostics Recordings::begin(double last_s) {
  if (Diagnostics why = refusal(); why.has_errors()) return why;
  (void)finish(false);
  return open(last_s);
}

Diagnostics Recordings::open(double last_s) {
  std::error_code error;
  std::string name;
  do name = fmt::format("recording_{:04}.mcap", ++count_);
  while (std::filesystem::exists(folder_ / name, error));
  run_.record_last = last_s;
  auto recorder = cell::RunRecorder::open(folder_ / name, description_, built_, run_);
  if (!recorder) return std::move(recorder.error());
  const std::lock_guard lock(mutex_);
  name_ = std::move(name);
  next_ = std::move(*recorder);
  wanted_ = true;
  status_.state = last_s > 0.0 ? State::kLast : State::kOn;
  status_.last_s = last_s;
  status_.error.clear();
  return {};
}

std::string Recordings::finish(bool keep) {
  std::unique_ptr<cell::RunRecorder> ended;
  {
    std::unique_lock lock(mutex_);
    if (status_.state == State::kOff) return {};
    wanted_ = false;
    // In lock-step no cycle may come for long: what no cycle has seen yet is taken back.
    if (next_ != nullptr) ended = std::move(next_);
    while (ended == nullptr && done_ == nullptr) {
      lock.unlock();
      std::this_thread::sleep_for(1ms);
      lock.lock();
    }
    if (ended == nullptr) ended = std::move(done_);
    status_.state = State::kOff;
  }
  if (keep) ended->keep();
  const record::RecorderStatus status = ended->close();
  const std::lock_guard lock(mutex_);
  status_.error = status.error;
  if (status.removed || !status.error.empty()) return {};
  status_.files.push_back(name_);
  return name_;
}

Diagnostics Recordings::end() {
  if (Diagnostics why = refusal(); why.has_errors()) return why;
  (void)finish(false);
  return {};
}

Result<std::string> Recordings::save() {
  if (Diagnostics why = refusal(); why.has_errors()) return std::unexpected(std::move(why));
  const Status before = status();
  if (before.state != State::kLast)
    return std::unexpected(refused(fmt::format("the recording is {}: nothing is kept in memory", name_of(before.state)),
                                   "Send state: last first"));
  const std::string name = finish(true);
  Diagnostics why = open(before.last_s);
  if (name.empty())
    why.error(Code::kFileNotWritable, "", "nothing could be written: " + status().error, "Free the disk");
  if (why.has_errors()) return std::unexpected(std::move(why));
  return name;
}

Recordings::Status Recordings::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Recordings::after_cycle() {
  if (active_ != nullptr) active_->add_cycle();
}

void Recordings::between_cycles(std::span<const rcc::Event> events) {
  if (active_ != nullptr) {
    for (const rcc::Event& event : events) {
      if (event.kind != rcc::Event::Kind::kState) continue;
      cell::LogEntry entry{.time = built_.core->time(),
                           .cycle = static_cast<std::uint64_t>(built_.core->cycle()),
                           .level = cell::LogLevel::kInfo,
                           .source = fmt::format("net {}", event.net),
                           .name = std::string(name_of(event.state)),
                           .text = std::string(event.cause.text.view())};
      active_->add_event(entry);
    }
  }
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;  // in the next cycle
  if (!wanted_ && active_ != nullptr && done_ == nullptr) done_ = std::move(active_);
  if (wanted_ && active_ == nullptr && next_ != nullptr) active_ = std::move(next_);
}

void Recordings::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    if (active_ != nullptr) done_ = std::move(active_);
  }
  (void)finish(false);
}

}  // namespace takt::serve
