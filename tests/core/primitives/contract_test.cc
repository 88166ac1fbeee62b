// What every primitive of the library owes the net (rows N1, N5, O3), tried on each registered type with the parameters
// of its own example, so that a new one cannot be left out.
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/net/compiled_net.h"
#include "core/net/example.h"
#include "core/net/registry.h"
#include "tests/core/primitives/environment.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using Json = nlohmann::ordered_json;

/// All types of the library; not the helpers of the harness.
std::vector<std::string> library() {
  std::vector<std::string> types;
  for (const net::PrimitiveInfo* info : net::Registry::global().all())
    if (info->family != "test") types.push_back(info->type);
  return types;
}

class Contract : public testing::TestWithParam<std::string> {
 protected:
  const net::PrimitiveInfo& info = *net::Registry::global().find(GetParam());
  DeviceEnvironment devices;
};

TEST_P(Contract, N1_O3_IsKept) {
  check_primitive_contract(GetParam(), net::example_parameters(info), {.environment = &devices});
}

TEST_P(Contract, N5_RecoversFromExtremes) {
  check_recovery(GetParam(), net::example_parameters(info), {.environment = &devices});
}

TEST_P(Contract, NullArisesOnlyWhereItIsDeclared) {
  check_declared_nulls(GetParam(), net::example_parameters(info), {.environment = &devices});
}

TEST_P(Contract, IsDocumented) {
  EXPECT_TRUE(info.doc.ends_with('.')) << info.doc;
  for (const auto* ports : {&info.inputs, &info.outputs})
    for (const auto& port : *ports) EXPECT_FALSE(port.spec.doc.empty()) << port.name;
  for (const auto& parameter : info.parameters) {
    EXPECT_FALSE(parameter.spec.doc.empty()) << parameter.name;
    const bool device = parameter.type.starts_with("device:");
    if (device || !parameter.fallback.empty()) continue;
    EXPECT_FALSE(Json::parse(parameter.spec.example, nullptr, false).is_discarded())
        << parameter.name << " must be given, so it needs an example";
  }
}

/// The net that `takt primitives NAME` shows loads and runs.
TEST_P(Contract, ItsExampleRuns) {
  auto net = net::CompiledNet::compile(net::example_net(info), devices);
  ASSERT_TRUE(net) << net.error().to_string();
  net::Cycle cycle;
  for (cycle.index = 0; cycle.index < 20; ++cycle.index) {
    const AllocationGuard guard;
    (*net)->evaluate(cycle);
    ASSERT_EQ(guard.count(), 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Library, Contract, testing::ValuesIn(library()), [](const auto& one) { return one.param; });

TEST(Library, HasTheFamiliesItPromises) {
  std::set<std::string> families;
  for (const net::PrimitiveInfo* info : net::Registry::global().all()) families.insert(info->family);
  for (const char* family :
       {"arithmetic", "channel", "comparison", "control",   "counter", "device",   "distance",   "edge",
        "filter",     "force",   "frame",      "generator", "history", "joints",   "kinematics", "latch",
        "limit",      "logic",   "net",        "null",      "path",    "rotation", "selection",  "source",
        "table",      "timer",   "twist",      "vector",    "wrench"})
    EXPECT_TRUE(families.contains(family)) << family;
  EXPECT_GE(library().size(), 250u);
}

}  // namespace
}  // namespace takt::test
