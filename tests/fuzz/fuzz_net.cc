// Any bytes at LOAD of a net lead to Ready, or to Rejected with place and reason; what is Ready runs.
#include <string_view>

#include "core/base/json.h"
#include "core/net/compiled_net.h"
#include "core/net/registry.h"
#include "tests/core/primitives/environment.h"
#include "tests/fuzz/fuzz_target.h"
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

namespace takt::test {

/// Half of the inputs change as nets, so that what comes behind the JSON is reached as well.
const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{.words = net_words(),
                                 .load = load,
                                 .share = 0.5,
                                 .mutate = [](std::string_view input, Random& random) -> std::optional<std::string> {
                                   const auto document = parse_json(input);
                                   return document ? std::optional(mutated_net(*document, random)) : std::nullopt;
                                 }};
  return target;
}

}  // namespace takt::test
