// Any bytes at LOAD of a net lead to Ready, or to Rejected with place and reason; what is Ready runs.
#include <cstdint>
#include <string_view>

#include "core/base/json.h"
#include "core/net/compiled_net.h"
#include "core/net/registry.h"
#include "tests/core/primitives/environment.h"
#include "tests/fuzz/net_mutator.h"
#include "tests/fuzz/promise.h"

namespace takt {
namespace {

using test::demand;
using test::expect_reasons;

constexpr int kCycles = 5;

void run(net::CompiledNet& net, test::DeviceEnvironment& devices) {
  for (int i = 0; i < kCycles; ++i) {
    net::Cycle cycle;
    cycle.index = i;
    cycle.time = i * cycle.period;
    cycle.cancel_requested = i >= 3;
    devices.arm->begin_cycle(i, cycle.time);
    devices.sensor->begin_cycle(i, cycle.time);
    net.evaluate(cycle);
  }
}

void load(std::string_view text) {
  static test::DeviceEnvironment devices;
  const auto document = parse_json(text);
  if (!document) return expect_reasons(document.error());
  const auto description = net::net_from_json(*document);
  if (!description) return expect_reasons(description.error());
  const auto again = net::net_from_json(net::net_to_json(*description));
  demand(again.has_value() && *again == *description, "what is written and read again is equal");
  const auto net = net::CompiledNet::compile(*description, devices);
  if (!net) return expect_reasons(net.error());
  run(**net, devices);
}

}  // namespace
}  // namespace takt

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  // What a net file is made of: words of the form, types, ports, parameters.
  takt::test::print_dictionary_if_asked(*argc, *argv, takt::test::net_words());
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  takt::load({reinterpret_cast<const char*>(data), size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t capacity);

/// Half of the time bytes, half of the time the net as such, so that what comes behind the JSON is reached as well.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t capacity,
                                               unsigned int seed) {
  takt::Random random(seed, "mutator");
  if (random.unit() < 0.5) {
    const auto document = takt::parse_json({reinterpret_cast<const char*>(data), size});
    if (document) {
      const std::string text = takt::test::mutated_net(*document, random);
      if (text.size() <= capacity) {
        std::copy(text.begin(), text.end(), data);
        return text.size();
      }
    }
  }
  return LLVMFuzzerMutate(data, size, capacity);
}
