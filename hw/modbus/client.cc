#include "hw/modbus/client.h"

#include <utility>

#include <fmt/format.h>

namespace takt::hw::modbus {
namespace {

using Kind = device::IoChannel::Kind;

constexpr Nanoseconds kRetryTime = 500 * kMillisecond;  // between two attempts to connect
constexpr std::size_t kNewsKept = 64;

/// What an exchange consists of: outputs first, so that inputs may answer to them a cycle later.
struct Part {
  Kind kind;
  Function function;
  const char* setting;  ///< that says where the terminals are
};
constexpr Part kParts[] = {{Kind::kDigitalOutput, Function::kWriteCoils, "digital_outputs"},
                           {Kind::kAnalogOutput, Function::kWriteRegisters, "analog_outputs"},
                           {Kind::kDigitalInput, Function::kReadDiscreteInputs, "digital_inputs"},
                           {Kind::kAnalogInput, Function::kReadInputRegisters, "analog_inputs"}};

const Part& part_of(Function function) {
  for (const Part& part : kParts)
    if (part.function == function) return part;
  std::unreachable();
}

}  // namespace

Client::Client(const ClientOptions& options, const device::IoRequest& request, CycleImage& image, Network& network,
               const Clock& clock)
    : options_(options),
      description_(request.description),
      map_(options.map, *description_),
      image_(image),
      network_(network),
      clock_(clock) {}

std::string Client::fault_text(std::uint32_t fault) {
  switch (static_cast<Fault>(fault)) {
    case Fault::kNone:
      return {};
    case Fault::kLost:
      return "the connection to the coupler is lost; check its cable and its power, and reset it when it is back";
    case Fault::kNotConnected:
      return "the coupler does not answer; check its address, its cable, and that it serves Modbus TCP";
    case Fault::kStarting:
      return "the first exchange is under way";
    case Fault::kRefused:
      return "the coupler refused a request";
    case Fault::kInterrupted:
      return "the connection broke, and outputs may have been switched off; reset it";
  }
  return {};
}

void Client::tell(std::string line) {
  const std::scoped_lock lock(news_mutex_);
  if (news_.size() < kNewsKept) news_.push_back(std::move(line));
}

void Client::keep_refusal(std::string why) {
  if (!why.empty()) tell(why);
  const std::scoped_lock lock(news_mutex_);
  refusal_ = std::move(why);
}

std::string Client::refusal() const {
  const std::scoped_lock lock(news_mutex_);
  return refusal_;
}

std::vector<std::string> Client::news() {
  const std::scoped_lock lock(news_mutex_);
  return std::exchange(news_, {});
}

void Client::lose(Nanoseconds now, const std::string& why) {
  if (open_) tell("connection lost: " + why);
  interrupted_ = interrupted_ || complete_;
  link_.close();
  open_ = complete_ = false;
  requests_.clear();
  asked_ = 0;
  due_ = now;
  publish();
}

void Client::keep_connected(Nanoseconds now) {
  switch (link_.state()) {
    case ByteLink::State::kConnecting:
      if (now - next_try_ > kRetryTime) link_.close();
      return;
    case ByteLink::State::kOpen:
      break;
    case ByteLink::State::kEnded:
    case ByteLink::State::kFailed:
      if (open_) lose(now, link_.state() == ByteLink::State::kEnded ? "closed by the coupler" : link_.error());
      if (now < next_try_) return;
      next_try_ = now + kRetryTime;
      parser_.reset();
      (void)link_.connect(network_, options_.remote);
      return;
  }
  if (open_) return;
  open_ = true;
  refused_ = false;
  keep_refusal({});
  ++counts_.connections;
  due_ = now;
  publish();
}

void Client::poll() {
  const Nanoseconds now = clock_.now();
  keep_connected(now);
  link_.receive([this](std::string_view bytes) { parser_.feed(bytes); });
  while (const auto frame = parser_.next()) handle(*frame, now);
  if (parser_.broken()) lose(now, "what answers does not speak Modbus TCP");
  if (reset_.exchange(false) && open_) {
    interrupted_ = refused_ = false;
    keep_refusal({});
    tell("reset");
  }
  if (open_ && !refused_ && now >= next_due()) {
    if (asked_ < requests_.size()) {
      lose(now, "no answer in time");
    } else {
      begin_exchange(now);
    }
  }
  link_.flush();
}

void Client::begin_exchange(Nanoseconds now) {
  began_ = now;
  requests_.clear();
  asked_ = 0;
  const OutputImage& outputs = image_.outputs();
  for (const Part& part : kParts) {
    const auto& list = map_.list(part.kind);
    Request request{part.function, map_.first(part.kind), static_cast<std::uint16_t>(list.size())};
    // Outputs are left alone until the block is known to be there, and after an interruption until a reset.
    if (list.empty() || (request.writes() && (!complete_ || interrupted_))) continue;
    for (std::size_t i = 0; request.writes() && i < list.size(); ++i)
      request.values.push_back(request.of_bits() ? static_cast<std::uint16_t>(outputs.digital >> i & 1)
                                                 : map_.raw_of(*list[i], outputs.analog[i]));
    requests_.push_back(std::move(request));
  }
  inputs_asked_ = now;
  if (requests_.empty()) {  // outputs alone: what says that the coupler is there is a read of them
    const bool digital = !map_.list(Kind::kDigitalOutput).empty();
    requests_.push_back({digital ? Function::kReadCoils : Function::kReadHoldingRegisters,
                         map_.first(digital ? Kind::kDigitalOutput : Kind::kAnalogOutput), 1});
  }
  ask(now);
}

void Client::ask(Nanoseconds now) {
  const Request& request = requests_[asked_];
  if (!request.writes() && (asked_ == 0 || requests_[asked_ - 1].writes())) inputs_asked_ = now;
  std::string bytes;
  append_frame(bytes, {++transaction_, options_.map.unit, encode(request)});
  link_.send(bytes);
  due_ = now;
}

void Client::handle(const Frame& frame, Nanoseconds now) {
  if (asked_ >= requests_.size() || frame.transaction != transaction_ || frame.unit != options_.map.unit) {
    ++counts_.strange;
    return;
  }
  const Request& request = requests_[asked_];
  values_.resize(request.count);
  const auto answer = parse_answer(request, frame.pdu, values_);
  if (!answer) {
    const std::string why(answer.error().exception ? name_of(*answer.error().exception) : "an answer of another form");
    const bool probe = request.function == Function::kReadCoils || request.function == Function::kReadHoldingRegisters;
    keep_refusal(fmt::format("function {} on addresses {} to {} refused: {}; check '{}' of the site, and unit {}",
                             static_cast<int>(request.function), request.address, request.address + request.count - 1,
                             why, probe ? "digital_outputs" : part_of(request.function).setting, options_.map.unit));
    refused_ = true;
    requests_.clear();
    asked_ = 0;
    return publish();
  }
  take(request);
  if (++asked_ < requests_.size()) return ask(now);
  complete(now);
}

void Client::take(const Request& request) {
  if (request.function == Function::kReadDiscreteInputs) {
    inputs_.digital = 0;
    for (std::size_t i = 0; i < values_.size(); ++i) inputs_.digital |= std::uint64_t{values_[i] != 0} << i;
  } else if (request.function == Function::kReadInputRegisters) {
    const auto& list = map_.list(Kind::kAnalogInput);
    for (std::size_t i = 0; i < values_.size(); ++i) inputs_.analog[i] = map_.value_of(*list[i], values_[i]);
  }
}

void Client::complete(Nanoseconds now) {
  ++counts_.exchanges;
  complete_ = true;
  // A cycle that took too long begins the next one at once, without catching up.
  due_ = std::max(began_ + options_.cycle, now);
  ++inputs_.sequence;
  inputs_.stamp = inputs_asked_;
  publish();
}

Fault Client::fault() const {
  if (!open_) return interrupted_ ? Fault::kLost : Fault::kNotConnected;
  if (refused_) return Fault::kRefused;
  if (interrupted_) return Fault::kInterrupted;
  return complete_ ? Fault::kNone : Fault::kStarting;
}

void Client::publish() {
  const Fault why = fault();
  inputs_.ready = why == Fault::kNone;
  inputs_.fault = static_cast<std::uint32_t>(why);
  image_.publish(inputs_);
}

/// What is on the wire is in the digest of the network.
void Client::add_state(emulation::StateHash& hash) const {
  hash.add(std::uint64_t{transaction_} | std::uint64_t{asked_} << 16 | std::uint64_t{inputs_.fault} << 32);
  hash.add(inputs_.sequence);
  hash.add(inputs_.digital);
  for (std::size_t i = 0; i < map_.list(Kind::kAnalogInput).size(); ++i) hash.add(inputs_.analog[i]);
  hash.add(due_);
}

}  // namespace takt::hw::modbus
