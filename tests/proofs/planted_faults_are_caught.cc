// A comparison that cannot fail proves nothing: here the compiler is wrong on purpose. What it decides about a net is
// data (core/net/net_plan.h); each class of fault changes that data in one place, and the comparison of
// compiled_net_equals_reference.cc must see it.
#include <array>
#include <optional>

#include <gtest/gtest.h>

#include "core/net/load_report.h"
#include "core/net/net_plan.h"
#include "core/net/schedule.h"
#include "tests/core/net/net_support.h"
#include "tests/core/net/random_net.h"
#include "tests/core/net/side_by_side.h"
#include "tests/support/random_runs.h"

namespace takt::net {
namespace {

constexpr int kCycles = 30;

/// A net on its way through the compiler, stopped before the plan is carried out.
struct Draft {
  explicit Draft(NetDescription net) : description(std::move(net)), flat(flatten(description, report)) {
    plan = plan_net(flat, schedule(flat, report));
  }

  [[nodiscard]] std::size_t input_number(int node, int port) const {
    return static_cast<std::size_t>(flat.input_base[static_cast<std::size_t>(node)] + port);
  }
  [[nodiscard]] const FlatLink* link_into(int node, int port) const {
    const int link = flat.input_link[input_number(node, port)];
    return link < 0 ? nullptr : &flat.links[static_cast<std::size_t>(link)];
  }
  [[nodiscard]] std::size_t output_place(int node, int port) const {
    return plan.output_place[static_cast<std::size_t>(flat.output_base[static_cast<std::size_t>(node)] + port)];
  }

  NetDescription description;
  LoadReport report;
  FlatNet flat;
  NetPlan plan;
};

/// Picks one of a list. nullptr if it is empty.
template <class T>
T* pick(std::vector<T>& list, Random& random) {
  return list.empty() ? nullptr : &list[random.bits() % list.size()];
}

struct Input {
  int node, port;
};

/// Inputs of primitives that read an output in the same cycle.
std::vector<Input> plain_inputs(const Draft& draft) {
  std::vector<Input> all;
  for (const int node : draft.plan.order) {
    for (int port = 0; port < draft.flat.input_count(node); ++port) {
      const FlatLink* link = draft.link_into(node, port);
      if (link != nullptr && !link->delayed) all.push_back({node, port});
    }
  }
  return all;
}

/// Another output of that type.
std::optional<std::size_t> other_output(const Draft& draft, ValueType type, std::size_t but, Random& random) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < draft.plan.output_count; ++i) {
    const CompiledNet::Port& port = draft.plan.ports[i];
    if (port.type == type && port.offset != but) places.push_back(port.offset);
  }
  const std::size_t* place = pick(places, random);
  return place == nullptr ? std::nullopt : std::optional(*place);
}

// Each plants one fault of its class. @return false if the net has no place for it.

/// A primitive runs before one that it reads.
bool order(Draft& draft, Random& random) {
  std::vector<std::size_t> places;
  for (std::size_t i = 1; i < draft.plan.order.size(); ++i) {
    const int before = draft.plan.order[i - 1], node = draft.plan.order[i];
    if (draft.flat.fragment_of(before) != draft.flat.fragment_of(node)) continue;
    for (int port = 0; port < draft.flat.input_count(node); ++port) {
      const FlatLink* link = draft.link_into(node, port);
      if (link != nullptr && !link->delayed && link->from == before) places.push_back(i);
    }
  }
  const std::size_t* at = pick(places, random);
  if (at == nullptr) return false;
  std::swap(draft.plan.order[*at - 1], draft.plan.order[*at]);
  return true;
}

/// An input reads another output of the same type.
bool binding(Draft& draft, Random& random) {
  std::vector<Input> inputs = plain_inputs(draft);
  const Input* input = pick(inputs, random);
  if (input == nullptr) return false;
  std::size_t& place = draft.plan.input_place[draft.input_number(input->node, input->port)];
  const auto other = other_output(draft, draft.flat.input(input->node, input->port).type, place, random);
  if (other) place = *other;
  return other.has_value();
}

/// A link is lost: its input reads null.
bool lost_link(Draft& draft, Random& random) {
  std::vector<Input> inputs = plain_inputs(draft);
  const Input* input = pick(inputs, random);
  if (input == nullptr) return false;
  draft.plan.input_place[draft.input_number(input->node, input->port)] = NetPlan::kNowhere;
  return true;
}

/// A constant is lost.
bool lost_constant(Draft& draft, Random& random) {
  const NetPlan::Constant* constant = pick(draft.plan.constants, random);
  if (constant == nullptr) return false;
  draft.plan.input_place[draft.input_number(constant->node, constant->port)] = NetPlan::kNowhere;
  return true;
}

/// A delayed link does not delay.
bool delay_left_out(Draft& draft, Random& random) {
  const NetPlan::Delay* delay = pick(draft.plan.delays, random);
  if (delay == nullptr) return false;
  draft.plan.input_place[draft.input_number(delay->node, delay->port)] = delay->source;
  return true;
}

/// What a delayed link remembers is never renewed.
bool delay_stands_still(Draft& draft, Random& random) {
  NetPlan::Delay* delay = pick(draft.plan.delays, random);
  if (delay != nullptr) delay->source = delay->initial;
  return delay != nullptr;
}

/// A delayed link remembers another output.
bool delay_of_another(Draft& draft, Random& random) {
  NetPlan::Delay* delay = pick(draft.plan.delays, random);
  if (delay == nullptr) return false;
  const auto other = other_output(draft, draft.flat.input(delay->node, delay->port).type, delay->source, random);
  if (other) delay->source = *other;
  return other.has_value();
}

/// A delayed link carries the value but not the null flag behind it.
bool null_flag_left_behind(Draft& draft, Random& random) {
  NetPlan::Delay* delay = pick(draft.plan.delays, random);
  if (delay == nullptr) return false;
  delay->size = visit_type(draft.flat.input(delay->node, delay->port).type,
                           []<class T>(std::type_identity<T>) { return offsetof(Slot<T>, null); });
  return true;
}

/// The initial value of a delayed link is lost: it begins with null.
bool lost_initial_value(Draft& draft, Random& random) {
  std::vector<NetPlan::Delay*> with_value;
  for (NetPlan::Delay& delay : draft.plan.delays) {
    if (!delay.initial_value->is_null()) with_value.push_back(&delay);
  }
  NetPlan::Delay** delay = pick(with_value, random);
  if (delay != nullptr) (*delay)->initial_value = nullptr;
  return delay != nullptr;
}

NetPlan::Gate* gate_of(Draft& draft, Random& random) { return pick(draft.plan.gates, random); }

/// A fragment that should begin anew goes on, or the other way round.
bool fragment_reset(Draft& draft, Random& random) {
  NetPlan::Gate* gate = gate_of(draft, random);
  if (gate == nullptr) return false;
  gate->when_inactive = gate->when_inactive == WhenInactive::kKeep ? WhenInactive::kReset : WhenInactive::kKeep;
  return true;
}

/// A fragment never rests.
bool always_active(Draft& draft, Random& random) {
  NetPlan::Gate* gate = gate_of(draft, random);
  if (gate == nullptr || gate->active == NetPlan::kNowhere) return false;
  gate->active = NetPlan::kNowhere;
  return true;
}

/// A fragment is switched by another Boolean.
bool activity_of_another(Draft& draft, Random& random) {
  NetPlan::Gate* gate = gate_of(draft, random);
  if (gate == nullptr || gate->active == NetPlan::kNowhere) return false;
  const auto other = other_output(draft, ValueType::kBoolean, gate->active, random);
  if (other) gate->active = *other;
  return other.has_value();
}

/// A fragment does not rest with the one around it.
bool lost_parent(Draft& draft, Random& random) {
  std::vector<NetPlan::Gate*> inner;
  for (NetPlan::Gate& gate : draft.plan.gates) {
    if (gate.parent >= 0) inner.push_back(&gate);
  }
  NetPlan::Gate** gate = pick(inner, random);
  if (gate != nullptr) (*gate)->parent = -1;
  return gate != nullptr;
}

/// An output of a resting fragment keeps its last value.
bool output_not_made_null(Draft& draft, Random& random) {
  NetPlan::Gate* gate = gate_of(draft, random);
  if (gate == nullptr || gate->outputs.empty()) return false;
  gate->outputs.erase(gate->outputs.begin() + static_cast<std::ptrdiff_t>(random.bits() % gate->outputs.size()));
  return true;
}

/// The members of a fragment run although it rests.
bool members_run_on(Draft& draft, Random& random) {
  std::vector<NetPlan::Step*> steps;
  for (NetPlan::Step& step : draft.plan.steps) {
    if (!step.is_gate && step.gate >= 0) steps.push_back(&step);
  }
  NetPlan::Step** step = pick(steps, random);
  if (step != nullptr) (*step)->gate = -1;
  return step != nullptr;
}

/// A fragment's delayed link is neither reset nor rests with it.
bool delay_outside_its_fragment(Draft& draft, Random& random) {
  std::vector<NetPlan::Delay*> inside;
  for (NetPlan::Delay& delay : draft.plan.delays) {
    if (delay.gate >= 0) inside.push_back(&delay);
  }
  NetPlan::Delay** delay = pick(inside, random);
  if (delay != nullptr) (*delay)->gate = -1;
  return delay != nullptr;
}

struct FaultClass {
  const char* name;
  bool (*plant)(Draft&, Random&);
};

constexpr std::array kClasses = {
    FaultClass{"order", order},
    FaultClass{"binding", binding},
    FaultClass{"lost_link", lost_link},
    FaultClass{"lost_constant", lost_constant},
    FaultClass{"delay_left_out", delay_left_out},
    FaultClass{"delay_stands_still", delay_stands_still},
    FaultClass{"delay_of_another", delay_of_another},
    FaultClass{"null_flag_left_behind", null_flag_left_behind},
    FaultClass{"lost_initial_value", lost_initial_value},
    FaultClass{"fragment_reset", fragment_reset},
    FaultClass{"always_active", always_active},
    FaultClass{"activity_of_another", activity_of_another},
    FaultClass{"lost_parent", lost_parent},
    FaultClass{"output_not_made_null", output_not_made_null},
    FaultClass{"members_run_on", members_run_on},
    FaultClass{"delay_outside_its_fragment", delay_outside_its_fragment},
};

/// What the comparison says about a net built from the (changed) plan.
std::string compare(Draft& draft) {
  TestDevices devices;
  const auto net = CompiledNet::from_plan(draft.flat, draft.plan, devices, draft.report);
  EXPECT_FALSE(draft.report.has_errors()) << draft.report.take().to_string();
  ReferenceNet reference(draft.description);
  return SideBySide(*net, reference).first_difference(kCycles);
}

NetDescription net_of(std::uint64_t seed) {
  Random random(seed, "nets");  // the nets of compiled_net_equals_reference.cc
  return random_net(random, 3 + static_cast<int>(seed % 40));
}

class PlantedFault : public testing::TestWithParam<FaultClass> {};

/// Not every planted fault changes a bit (an input may be bound to an output with equal values), so what counts is how
/// many nets it takes until one does: far fewer than the proof runs.
TEST_P(PlantedFault, IsCaught) {
  const test::RandomRuns runs(400);
  long planted = 0, caught = 0, until_first = 0;
  std::string example;
  for (long i = 0; i < runs.count; ++i) {
    const std::uint64_t seed = runs.first_seed + static_cast<std::uint64_t>(i);
    Draft draft(net_of(seed));
    Random random(seed, GetParam().name);
    if (!GetParam().plant(draft, random)) continue;
    ++planted;
    const std::string difference = compare(draft);
    if (difference.empty()) continue;
    if (caught++ == 0) {
      until_first = i + 1;
      example = difference;
    }
  }
  std::printf("%s: planted in %ld nets, seen in %ld, first in net %ld: %s\n", GetParam().name, planted, caught,
              until_first, example.c_str());
  EXPECT_GT(planted, runs.count / 20) << "the random nets hardly have a place for this fault";
  EXPECT_GT(caught, 0) << "the comparison is blind for this fault";
  EXPECT_LE(until_first, 100);
}

INSTANTIATE_TEST_SUITE_P(Compiler, PlantedFault, testing::ValuesIn(kClasses),
                         [](const auto& one) { return std::string(one.param.name); });

/// Without a fault the same way through the compiler shows no difference.
TEST(NoFault, IsNotCaught) {
  const test::RandomRuns runs(400);
  for (long i = 0; i < runs.count; ++i) {
    Draft draft(net_of(runs.first_seed + static_cast<std::uint64_t>(i)));
    ASSERT_EQ(compare(draft), "") << "net " << i;
  }
}

}  // namespace
}  // namespace takt::net
