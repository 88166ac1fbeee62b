// Any bytes at LOAD of a net lead to Ready, or to Rejected with place and reason; what is Ready runs.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "core/base/json.h"
#include "core/net/compiled_net.h"
#include "core/net/registry.h"
#include "tests/core/primitives/environment.h"
#include "tests/fuzz/net_mutator.h"

namespace takt {
namespace {

constexpr int kCycles = 5;

void demand(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

void expect_reasons(const Findings& findings) {
  demand(findings.has_errors(), "a rejected net has at least one error");
  for (const Finding& finding : findings.list()) demand(!finding.message.empty(), "every finding says something");
}

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

/// What a net file is made of, as a dictionary for libFuzzer: words of the form, types, ports, parameters.
void print_dictionary() {
  for (const std::string& word : test::net_words()) std::printf("\"\\\"%s\\\"\"\n", word.c_str());
}

}  // namespace
}  // namespace takt

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc > 1 && std::string_view((*argv)[1]) == "--dictionary") {
    takt::print_dictionary();
    std::exit(0);
  }
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
