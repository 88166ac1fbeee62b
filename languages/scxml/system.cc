#include "languages/scxml/system.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::languages {
namespace {

/// Sessions that run at once, with those that charts invoke.
constexpr std::size_t kMostSessions = 64;
/// Events that wait for their time.
constexpr std::size_t kMostDelayed = 10'000;
/// Steps of all sessions at one instant: more are charts that keep each other busy.
constexpr int kMostSteps = 20'000;

}  // namespace

ChartSession& ChartSystem::add(std::shared_ptr<const Chart> chart, const std::string& name) {
  sessions_.push_back(std::make_unique<ChartSession>(*this, std::move(chart), name));
  charts_.push_back(sessions_.back().get());
  given_[charts_.back()] = {};
  return *charts_.back();
}

void ChartSystem::advance(std::int64_t now_ns) {
  for (int events = 0;; ++events) {
    run_ready();
    if (delayed_.empty() || delayed_.begin()->first.first > now_ns) break;
    now_ = std::max(now_, delayed_.begin()->first.first);
    Delayed due = std::move(delayed_.begin()->second);
    delayed_.erase(delayed_.begin());
    if (events >= kMostSteps) {
      due.from->fail(fmt::format("{} events are due before the clock goes on", kMostSteps));
      due.from->end();
      continue;
    }
    const std::string sendid = due.event.sendid;
    const auto [error, why] = send(*due.from, due.target, std::move(due.event));
    if (!error.empty()) (void)due.from->error(error, why, sendid);
  }
  now_ = std::max(now_, now_ns);
}

void ChartSystem::run_ready() {
  int steps = 0;
  for (bool did = true; did;) {
    did = false;
    for (std::size_t i = 0; i < sessions_.size(); ++i) {
      ChartSession& session = *sessions_[i];
      if (const auto given = given_.find(&session); given != given_.end()) {
        const auto values = std::move(given->second);
        given_.erase(given);
        session.start(values);
        if (!session.running()) session.end();
        did = true;
      }
      did = session.step() || did;
      if (++steps > kMostSteps && session.running()) {
        session.fail(fmt::format("{} steps of all charts at one instant", kMostSteps));
        session.end();
      }
    }
    // Children that are over are gone; those that were added stay for whoever asks.
    std::erase_if(sessions_, [&](const auto& session) {
      return !session->started_ && !given_.contains(session.get()) &&
             std::ranges::find(charts_, session.get()) == charts_.end();
    });
  }
}

bool ChartSystem::post(std::string_view name, ChartEvent event) {
  ChartSession* const session = find(name);
  if (session == nullptr) return false;
  session->post(std::move(event));
  return true;
}

bool ChartSystem::end_call(std::string_view name, const std::string& id, ChartEvent event) {
  ChartSession* const session = find(name);
  if (session == nullptr) return false;
  const bool waits = std::ranges::any_of(session->calls_, [&](const auto& call) { return call.id == id; });
  if (!waits) return false;
  event.invokeid = id;
  session->post(std::move(event));
  return true;
}

void ChartSystem::cancel() {
  for (ChartSession* const chart : charts_) chart->cancel();
  run_ready();
}

ChartSession* ChartSystem::find(std::string_view name) const {
  const auto found = std::ranges::find_if(
      sessions_, [&](const auto& one) { return one->id() == name && (one->running() || given_.contains(one.get())); });
  return found == sessions_.end() ? nullptr : found->get();
}

bool ChartSystem::over() const {
  return std::ranges::none_of(charts_, [&](const ChartSession* one) { return one->running() || given_.contains(one); });
}

std::int64_t ChartSystem::next_ns() const { return delayed_.empty() ? -1 : delayed_.begin()->first.first; }

std::pair<std::string_view, std::string> ChartSystem::send(ChartSession& from, const std::string& target,
                                                           ChartEvent event) {
  if (target == "#_internal") {
    event.type = ChartEvent::Type::kInternal;
    event.origin.clear();
    event.origintype.clear();
    from.raise(std::move(event));
    return {};
  }
  ChartSession* to = nullptr;
  if (target.empty()) {
    to = &from;
  } else if (target == "#_parent") {
    to = from.parent_.session;
    event.invokeid = from.parent_.invoke_id;
  } else if (target.starts_with("#_scxml_")) {
    to = find(std::string_view(target).substr(8));
  } else if (target.starts_with("#_")) {
    const std::string id = target.substr(2);
    for (const auto& call : from.calls_)
      if (call.id == id) to = call.child;
  } else {
    return {"error.execution", fmt::format("'{}' is no target of an event", target)};
  }
  if (to == nullptr || (!to->running() && !given_.contains(to)))
    return {"error.communication", fmt::format("there is no session '{}'", target)};
  to->post(std::move(event));
  return {};
}

bool ChartSystem::send_later(ChartSession& from, std::int64_t delay_ns, std::string target, ChartEvent event) {
  if (delayed_.size() >= kMostDelayed) return false;
  delayed_.emplace(std::pair{now_ + delay_ns, ++sent_}, Delayed{&from, std::move(target), std::move(event)});
  return true;
}

void ChartSystem::cancel_later(const ChartSession& from, const std::string& sendid) {
  std::erase_if(delayed_,
                [&](const auto& one) { return one.second.from == &from && one.second.event.sendid == sendid; });
}

ChartSession* ChartSystem::add_child(ChartSession& parent, std::shared_ptr<const Chart> chart,
                                     const std::string& invoke_id, std::map<std::string, Data> given) {
  if (sessions_.size() >= kMostSessions) return nullptr;
  sessions_.push_back(
      std::make_unique<ChartSession>(*this, std::move(chart), fmt::format("{}.{}", parent.id(), ++children_)));
  ChartSession* const child = sessions_.back().get();
  child->parent_ = {&parent, invoke_id};
  given_[child] = std::move(given);
  return child;
}

void ChartSystem::session_over(ChartSession& session, bool in_order) {
  std::erase_if(delayed_, [&](const auto& one) { return one.second.from == &session; });
  for (const auto& other : sessions_) {
    if (other->parent_.session == &session) other->parent_ = {};
  }
  ChartSession* const parent = session.parent_.session;
  if (parent == nullptr) return;
  const std::string id = session.parent_.invoke_id;
  session.parent_ = {};
  if (in_order) {
    parent->post({.name = "done.invoke." + id, .invokeid = id, .data = session.result()});
  } else if (!session.failure().empty()) {
    (void)parent->error("error.communication", session.failure(), id);
  }
  for (auto& call : parent->calls_)
    if (call.child == &session) call.child = nullptr;
}

}  // namespace takt::languages
