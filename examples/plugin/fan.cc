#include "fan.h"

#include <cmath>
#include <utility>

namespace fan {

using takt::net::Text;

Fan::Fan(std::string name, std::shared_ptr<const FanDescription> description, std::shared_ptr<FanBackend> backend)
    : Actuator(std::move(name)), description_(std::move(description)), backend_(std::move(backend)) {}

void Fan::begin_cycle(std::int64_t, takt::Nanoseconds) {
  measured_ = backend_->read();
  proposed_.reset();
}

void Fan::add_state(takt::device::StateWords& words) const {
  words.add(std::int64_t{measured_ ? 1 : 0});
  words.add(measured_.value_or(0.0));
  words.add(sent_);
}

Text Fan::fault() const { return Text("no sample of the fan's speed"); }

std::optional<Text> Fan::refusal() const {
  if (lost()) return fault();
  return std::nullopt;
}

void Fan::stop() {
  held_ = false;
  proposed_ = 0.0;
}

std::optional<Text> Fan::check() {
  if (!proposed_ || (std::isfinite(*proposed_) && *proposed_ >= 0.0 && *proposed_ <= description_->speed_max)) {
    return std::nullopt;
  }
  stop();
  return Text("the fan's speed is beyond its limits");
}

void Fan::hand_over() {
  // Held without a wish it goes on as it turns; let go of, it stands from the cycle after on.
  if (proposed_) {
    sent_ = *proposed_;
  } else if (!held_) {
    sent_ = 0.0;
  }
  backend_->write(sent_);
}

}  // namespace fan
