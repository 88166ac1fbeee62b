#include "core/device/signal.h"

#include <algorithm>
#include <cmath>

#include "core/net/format_text.h"

namespace takt::device {

namespace {

/// Against rounding in the difference of two values, as the guard of arms has it.
constexpr double kRateTolerance = 1e-3;

std::uint64_t word_of(bool value) { return value ? 1 : 0; }
double word_of(double value) { return value; }

bool is_value(bool) { return true; }
bool is_value(double value) { return std::isfinite(value); }

/// A digital value is never wrong.
std::optional<net::Text> find_fault(const std::string&, const SignalOutputDescription<bool>&, bool, bool, double) {
  return std::nullopt;
}

std::optional<net::Text> find_fault(const std::string& name, const SignalOutputDescription<double>& d, double next,
                                    double last, double step_max) {
  const double step = std::abs(next - last);
  if (!std::isfinite(next)) return net::format_text("{}: the value is not finite", name);
  if (next < d.lower || next > d.upper)
    return net::format_text("{}: {:.4g} outside [{:.4g}, {:.4g}] {}", name, next, d.lower, d.upper, d.unit);
  if (step > step_max * (1.0 + kRateTolerance))
    return net::format_text("{}: step of {:.4g} {} beyond {:.4g} a cycle", name, step, d.unit, step_max);
  return std::nullopt;
}

}  // namespace

template <class T>
void SignalInput<T>::begin_cycle(std::int64_t, Nanoseconds time) {
  has_sample_ = at_border([this] { return backend_->read(sample_); }) && is_value(sample_.value);
  sample_age_ = has_sample_ ? time - sample_.stamp : 0;
  if (sample_age_ > description_.sample_age_max) has_sample_ = false;
}

template <class T>
void SignalInput<T>::add_state(StateWords& words) const {
  words.add(std::uint64_t{has_sample_});
  if (!has_sample_) return;
  words.add(sample_.sequence);
  words.add(sample_.stamp);
  words.add(word_of(sample_.value));
}

template <class T>
SignalOutput<T>::SignalOutput(std::string name, SignalOutputDescription<T> description,
                              std::shared_ptr<SignalOutputBackend<T>> backend, Nanoseconds period)
    : Actuator(std::move(name)),
      description_(std::move(description)),
      signal_{.unit = description_.unit, .frame = {}},
      backend_(std::move(backend)),
      step_max_(description_.rate_max * to_seconds(period)),
      sent_(description_.initial) {}

template <class T>
void SignalOutput<T>::begin_cycle(std::int64_t, Nanoseconds) {
  proposed_ = false;
  const bool failed = failed_before();
  ready_ = at_border([this] { return backend_->ready(); }) && !failed;
}

template <class T>
void SignalOutput<T>::add_state(StateWords& words) const {
  words.add(std::uint64_t{ready_} | std::uint64_t{held_} << 1 | std::uint64_t{stopping_} << 2);
  words.add(word_of(sent_));
}

template <class T>
net::Text SignalOutput<T>::fault() const {
  if (exception()) return *exception();
  return net::format_text("{}: not ready", name());
}

template <class T>
std::optional<net::Text> SignalOutput<T>::refusal() const {
  if (!ready_) return fault();
  if (stopping_) return net::format_text("{}: its stop reaction runs", name());
  return std::nullopt;
}

template <class T>
void SignalOutput<T>::stop() {
  held_ = false;
  proposed_ = false;
  stopping_ = description_.stop && *description_.stop != sent_;
}

template <class T>
std::optional<net::Text> SignalOutput<T>::check() {
  if (!proposed_) return std::nullopt;
  auto trip = find_fault(name(), description_, proposal_, sent_, step_max_);
  if (trip) stop();
  return trip;
}

template <class T>
void SignalOutput<T>::hand_over() {
  if (!ready_) return;
  if (stopping_) {
    approach_stop_value();
  } else if (proposed_) {
    sent_ = proposal_;
  }
  call_border([this] { backend_->write(sent_); });
}

template <class T>
void SignalOutput<T>::approach_stop_value() {
  const T goal = *description_.stop;
  if constexpr (std::is_same_v<T, double>) {
    sent_ = std::abs(goal - sent_) <= step_max_ ? goal : sent_ + std::copysign(step_max_, goal - sent_);
  } else {
    sent_ = goal;
  }
  stopping_ = sent_ != goal;
}

template class SignalInput<bool>;
template class SignalInput<double>;
template class SignalOutput<bool>;
template class SignalOutput<double>;

}  // namespace takt::device
