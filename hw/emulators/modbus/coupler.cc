#include "hw/emulators/modbus/coupler.h"

#include <algorithm>
#include <utility>

namespace takt::hw::modbus {
namespace {

using device::IoChannel;
using Kind = device::IoChannel::Kind;

constexpr std::size_t kCouplerNews = 64;

}  // namespace

Coupler::Coupler(const CouplerOptions& options, std::shared_ptr<const device::IoDescription> description,
                 Network& network, device::IoTerminals machine)
    : options_(options),
      description_(std::move(description)),
      map_(options.map, *description_),
      network_(network),
      machine_(std::move(machine)),
      coils_(map_.list(Kind::kDigitalOutput).size()),
      discrete_inputs_(map_.list(Kind::kDigitalInput).size()),
      input_registers_(map_.list(Kind::kAnalogInput).size()),
      holding_registers_(map_.list(Kind::kAnalogOutput).size()) {
  clear_outputs();
}

Result<void> Coupler::listen(const Endpoint& local) {
  auto listener = network_.listen(local);
  if (!listener) return std::unexpected(listener.error());
  listener_ = std::move(*listener);
  return {};
}

std::vector<std::string> Coupler::news() { return std::exchange(news_, {}); }

void Coupler::clear_outputs() {
  std::ranges::fill(coils_, std::uint16_t{0});
  std::ranges::fill(holding_registers_, std::uint16_t{0});
}

void Coupler::restart() {
  clients_.clear();
  heard_ = expired_ = false;
  clear_outputs();
}

void Coupler::advance(Nanoseconds now) {
  serve(now);
  look(now);
}

void Coupler::look(Nanoseconds now) {
  if (heard_ && !expired_ && options_.watchdog > 0 && now - heard_at_ > options_.watchdog) {
    expired_ = true;
    clear_outputs();
    if (news_.size() < kCouplerNews) news_.emplace_back("no request in time: the outputs are switched off");
  }
  for (std::size_t i = 0; i < discrete_inputs_.size(); ++i) {
    device::SignalSample<bool> sample;
    if (machine_.digital_inputs.at(map_.list(Kind::kDigitalInput)[i]->name)->read(sample))
      discrete_inputs_[i] = sample.value ? 1 : 0;
  }
  for (std::size_t i = 0; i < input_registers_.size(); ++i) {
    const IoChannel& channel = *map_.list(Kind::kAnalogInput)[i];
    device::SignalSample<double> sample;
    if (machine_.analog_inputs.at(channel.name)->read(sample) && std::isfinite(sample.value))
      input_registers_[i] = map_.raw_of(channel, sample.value);
  }
  for (std::size_t i = 0; i < coils_.size(); ++i)
    machine_.digital_outputs.at(map_.list(Kind::kDigitalOutput)[i]->name)->write(coils_[i] != 0);
  for (std::size_t i = 0; i < holding_registers_.size(); ++i) {
    const IoChannel& channel = *map_.list(Kind::kAnalogOutput)[i];
    machine_.analog_outputs.at(channel.name)->write(map_.value_of(channel, holding_registers_[i]));
  }
}

/// Who knows no unit asks for 255, which TCP recommends, or for 0.
bool Coupler::is_own(std::uint8_t unit) const {
  constexpr std::uint8_t kNoUnit = 255, kAnyUnit = 0;
  return unit == options_.map.unit || unit == kNoUnit || unit == kAnyUnit;
}

void Coupler::serve(Nanoseconds now) {
  if (listener_ == nullptr) return;
  while (auto link = listener_->accept()) {
    if (clients_.size() >= kMostClients) continue;
    clients_.push_back(std::make_unique<Client>());
    clients_.back()->link = ByteLink(std::move(link));
  }
  for (const auto& client : clients_) serve(*client, now);
  std::erase_if(clients_, [](const auto& client) { return !client->link.open() || client->parser.broken(); });
}

void Coupler::serve(Client& client, Nanoseconds now) {
  client.link.receive([&](std::string_view bytes) { client.parser.feed(bytes); });
  while (const auto frame = client.parser.next()) {
    // Requests for other units behind a gateway: there is none.
    if (!is_own(frame->unit)) continue;
    heard_at_ = now;
    heard_ = true;
    std::string bytes;
    append_frame(bytes, {frame->transaction, frame->unit, answer(frame->pdu)});
    client.link.send(bytes);
  }
  client.link.flush();
}

std::vector<std::uint16_t>& Coupler::table_of(Function function) {
  switch (function) {
    case Function::kReadDiscreteInputs:
      return discrete_inputs_;
    case Function::kReadInputRegisters:
      return input_registers_;
    case Function::kReadCoils:
    case Function::kWriteCoil:
    case Function::kWriteCoils:
      return coils_;
    case Function::kReadHoldingRegisters:
    case Function::kWriteRegister:
    case Function::kWriteRegisters:
      break;
  }
  return holding_registers_;
}

std::uint16_t Coupler::first_of(Function function) const {
  switch (function) {
    case Function::kReadDiscreteInputs:
      return map_.first(Kind::kDigitalInput);
    case Function::kReadInputRegisters:
      return map_.first(Kind::kAnalogInput);
    case Function::kReadCoils:
    case Function::kWriteCoil:
    case Function::kWriteCoils:
      return map_.first(Kind::kDigitalOutput);
    case Function::kReadHoldingRegisters:
    case Function::kWriteRegister:
    case Function::kWriteRegisters:
      break;
  }
  return map_.first(Kind::kAnalogOutput);
}

std::string Coupler::answer(std::string_view pdu) {
  const auto function = pdu.empty() ? std::uint8_t{0} : static_cast<std::uint8_t>(pdu[0]);
  const auto request = parse_request(pdu);
  if (!request) return encode_exception(function, request.error());
  std::vector<std::uint16_t>& table = table_of(request->function);
  const std::size_t begin = std::size_t{request->address} - first_of(request->function);
  if (request->address < first_of(request->function) || begin + request->count > table.size())
    return encode_exception(function, Exception::kIllegalAddress);
  const std::span part = std::span(table).subspan(begin, request->count);
  if (!request->writes()) return encode_answer(*request, part);
  expired_ = false;
  std::ranges::copy(request->values, part.begin());
  return encode_answer(*request, {});
}

}  // namespace takt::hw::modbus
