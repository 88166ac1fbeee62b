#pragma once

#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/net/compiled_net.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/net/value_json.h"
#include "tests/support/allocation_guard.h"

namespace takt::test {

/// One primitive in a net of its own, with inputs to set, cycles to run and outputs to read.
///
///   PrimitiveHarness add("Add");
///   add.set("a", 1.0).set("b", 2.0).step();
///   EXPECT_EQ(add.get<net::Real>("sum"), 3.0);   // std::nullopt = null
///
/// Inputs are null until set; an input that has a constant among the parameters is not fed. Every cycle runs under the
/// allocation guard. Needs takt_core_net and the library of the primitive.
struct HarnessOptions {
  net::Environment* environment = nullptr;  ///< devices; nullptr: none
  std::set<std::string> unlinked = {};      ///< optional inputs that stay unlinked
};

namespace harness {

using Json = nlohmann::ordered_json;

/// Holds the value of one input; primitives find it by the input's name.
template <class T>
class Cell : public net::Resource {
 public:
  [[nodiscard]] std::string_view kind() const override { return "harness"; }
  std::optional<T> value;
};

template <class T>
class Source : public net::Primitive {
 public:
  explicit Source(net::Setup& setup)
      : cell_(setup.device<Cell<T>>("cell", "harness", "what to give")),
        out_(setup.out<T>("out", {.may_be_null = true})) {}
  void update(const net::Cycle&) override {
    if (!cell_->value) return out_.set_null();
    out_.set(*cell_->value);
  }

 private:
  Cell<T>* cell_;
  net::Out<T> out_;
};

class Endless : public net::Primitive {
 public:
  explicit Endless(net::Setup& setup) { setup.is_termination(); }
  void update(const net::Cycle&) override {}
};

template <class T>
std::string source_type() {
  return fmt::format("HarnessSource{}", net::name_of(net::kValueType<T>));
}

inline void register_types() {
  static const bool once = [] {
    net::Registry& registry = net::Registry::global();
    for (int t = 0; t <= static_cast<int>(net::ValueType::kJoints); ++t) {
      net::visit_type(static_cast<net::ValueType>(t), [&]<class T>(std::type_identity<T>) {
        registry.add(source_type<T>(), "test", "gives what the test sets", net::Maker::of<Source<T>>());
      });
    }
    return registry.add("HarnessEndless", "test", "a Termination that never ends", net::Maker::of<Endless>());
  }();
  (void)once;
}

/// The cells by name, then what the test brings.
class CellEnvironment : public net::Environment {
 public:
  explicit CellEnvironment(net::Environment* outer) : outer_(outer) {}
  net::Resource* find(std::string_view name) override {
    const auto cell = cells.find(std::string(name));
    if (cell != cells.end()) return cell->second.get();
    return outer_ == nullptr ? nullptr : outer_->find(name);
  }
  [[nodiscard]] std::vector<std::string> names() const override {
    return outer_ == nullptr ? std::vector<std::string>() : outer_->names();
  }
  std::map<std::string, std::unique_ptr<net::Resource>> cells;

 private:
  net::Environment* outer_;
};

/// Which numbers a random value is made of: ordinary ones, the ends of what a double holds, or now and then such.
enum class Numbers { kModerate, kExtreme, kMixed };

inline double random_number(Random& random, Numbers numbers) {
  constexpr double kEnds[] = {0.0,
                              -0.0,
                              1e300,
                              -1e300,
                              std::numeric_limits<double>::max(),
                              1e-300,
                              -1e-300,
                              1e150,
                              -1e150,
                              std::numeric_limits<double>::lowest(),
                              std::numeric_limits<double>::denorm_min(),
                              -std::numeric_limits<double>::denorm_min()};
  const bool end = numbers == Numbers::kExtreme || (numbers == Numbers::kMixed && random.unit() < 0.2);
  return end ? kEnds[random.bits() % std::size(kEnds)] : random.uniform(-2.0, 2.0);
}

/// Any value a port may carry.
template <class T>
T random_value(Random& random, Numbers numbers = Numbers::kMixed) {
  const auto number = [&] { return random_number(random, numbers); };
  if constexpr (std::is_same_v<T, net::Boolean>) {
    return random.unit() < 0.5;
  } else if constexpr (std::is_same_v<T, net::Integer>) {
    const bool any = numbers == Numbers::kExtreme || (numbers == Numbers::kMixed && random.unit() < 0.1);
    return any ? static_cast<net::Integer>(random.bits()) : static_cast<net::Integer>(random.uniform(-5.0, 6.0));
  } else if constexpr (std::is_same_v<T, net::Real>) {
    return number();
  } else if constexpr (std::is_same_v<T, net::Text>) {
    return net::Text(std::to_string(random.bits() % 5));
  } else if constexpr (std::is_same_v<T, net::Vector>) {
    return {number(), number(), number()};
  } else if constexpr (std::is_same_v<T, net::Rotation>) {
    return net::Rotation(random.normal(), random.normal(), random.normal(), 0.1 + random.unit()).normalized();
  } else if constexpr (std::is_same_v<T, net::Frame>) {
    net::Frame frame = net::Frame::Identity();
    frame.linear() = random_value<net::Rotation>(random).toRotationMatrix();
    frame.translation() = random_value<net::Vector>(random, numbers);
    return frame;
  } else if constexpr (std::is_same_v<T, net::JointArray>) {
    net::JointArray joints;
    joints.size = 7;
    for (int i = 0; i < 7; ++i) joints.value[static_cast<std::size_t>(i)] = number();
    return joints;
  } else {
    return {random_value<net::Vector>(random, numbers), random_value<net::Vector>(random, numbers)};
  }
}

}  // namespace harness

class PrimitiveHarness {
 public:
  using Json = nlohmann::ordered_json;

  explicit PrimitiveHarness(std::string type, Json parameters = Json::object(), HarnessOptions options = {},
                            bool in_fragment = false)
      : environment_(options.environment) {
    harness::register_types();
    info_ = net::Registry::global().find(type);
    if (info_ == nullptr) {
      ADD_FAILURE() << "no primitive type '" << type << "' is registered";
      return;
    }
    net::NetDescription description;
    net::NetDescription inner;
    inner.add("x", type, parameters);
    std::vector<std::pair<std::string, std::string>> ports;
    for (const auto& input : info_->inputs) {
      if (parameters.contains(input.name) || options.unlinked.contains(input.name)) continue;
      add_source(description, input.name, input.type);
      description.link("in-" + input.name + ".out", in_fragment ? "f." + input.name : "x." + input.name);
      ports.emplace_back(input.name, "x." + input.name);
      linked_.push_back(&input);
    }
    description.add("end", "HarnessEndless");
    if (in_fragment) {
      add_source(description, "active", net::ValueType::kBoolean);
      description.link("in-active.out", "f.active");
      description.fragments.push_back({"f", net::WhenInactive::kReset, inner, ports, {}});
    } else {
      description.primitives.push_back(inner.primitives.front());
    }
    prefix_ = in_fragment ? "f/x." : "x.";
    auto net = net::CompiledNet::compile(description, environment_);
    if (net) {
      net_ = std::move(*net);
    } else {
      diagnostics_ = std::move(net.error());
    }
  }

  /// Whether LOAD took it; otherwise diagnostics() says why. Use it in tests of bad parameters.
  [[nodiscard]] bool ready() const { return net_ != nullptr; }
  [[nodiscard]] const Diagnostics& diagnostics() const { return diagnostics_; }

  template <class T>
  PrimitiveHarness& set(const std::string& input, const T& value) {
    if (auto* cell = this->cell<T>(input)) cell->value = value;
    return *this;
  }
  PrimitiveHarness& set(const std::string& input, int value) {  // `set("n", 3)` means what the port takes
    return type_of(input) == net::ValueType::kReal ? set<net::Real>(input, value) : set<net::Integer>(input, value);
  }
  PrimitiveHarness& set_null(const std::string& input) {
    net::visit_type(type_of(input), [&]<class T>(std::type_identity<T>) {
      if (auto* typed = this->cell<T>(input)) typed->value.reset();
    });
    return *this;
  }
  PrimitiveHarness& set_random(const std::string& input, Random& random,
                               harness::Numbers numbers = harness::Numbers::kMixed) {
    net::visit_type(type_of(input),
                    [&]<class T>(std::type_identity<T>) { set<T>(input, harness::random_value<T>(random, numbers)); });
    return *this;
  }
  /// Feeds every input anew, then runs a cycle, a number of times.
  PrimitiveHarness& step_random(int cycles, Random& random, harness::Numbers numbers) {
    for (int i = 0; i < cycles; ++i) {
      for (const auto* input : linked_) set_random(input->name, random, numbers);
      step();
    }
    return *this;
  }

  /// Runs cycles; none may allocate.
  PrimitiveHarness& step(int cycles = 1) {
    if (net_ == nullptr) {
      ADD_FAILURE() << "the net was rejected:\n" << diagnostics_.to_string();
      return *this;
    }
    for (int i = 0; i < cycles; ++i) {
      cycle.dt = to_seconds(cycle.period);
      const AllocationGuard guard;
      net_->evaluate(cycle);
      const std::size_t allocations = guard.count();
      EXPECT_EQ(allocations, 0u) << info_->type << " allocates in cycle " << cycle.index;
      ++cycle.index;
      cycle.time += cycle.period;
    }
    return *this;
  }

  /// The output as it was set in the last cycle; std::nullopt = null.
  template <class T>
  [[nodiscard]] std::optional<T> get(const std::string& output) const {
    const net::Slot<T>* slot = net_ == nullptr ? nullptr : net_->find<T>(prefix_ + output);
    if (slot == nullptr) {
      ADD_FAILURE() << "no output '" << output << "' of that type";
      return std::nullopt;
    }
    return slot->null != 0 ? std::nullopt : std::optional<T>(slot->value);
  }
  [[nodiscard]] bool is_null(const std::string& output) const { return get_json(output).is_null(); }
  [[nodiscard]] Json get_json(const std::string& output) const {
    for (const auto& port : info_->outputs) {
      if (port.name == output && net_ != nullptr) {
        return net::slot_to_json(port.type, net_->find_slot(prefix_ + output, port.type));
      }
    }
    ADD_FAILURE() << "no output '" << output << "'";
    return nullptr;
  }
  /// Bytes of all outputs of the primitive, for comparisons bit by bit.
  [[nodiscard]] std::string output_bytes() const {
    std::string bytes;
    for (const auto& port : net_->ports()) {
      if (!port.name.starts_with(prefix_)) continue;
      bytes.append(reinterpret_cast<const char*>(net_->slots().data()) + port.offset, port.size);
    }
    return bytes;
  }

  [[nodiscard]] const net::PrimitiveInfo& info() const { return *info_; }
  /// The inputs that set() feeds.
  [[nodiscard]] const std::vector<const net::PrimitiveInfo::Port*>& linked() const { return linked_; }
  [[nodiscard]] const net::NetSignals& signals() const { return net_->signals(); }
  [[nodiscard]] net::CompiledNet& net() { return *net_; }

  net::Cycle cycle;  ///< of the next step: period, cancel_requested, ...

 private:
  void add_source(net::NetDescription& description, const std::string& input, net::ValueType type) {
    const std::string name = "harness-" + input;
    net::visit_type(type, [&]<class T>(std::type_identity<T>) {
      environment_.cells[name] = std::make_unique<harness::Cell<T>>();
      description.add("in-" + input, harness::source_type<T>(), {{"cell", name}});
    });
  }
  [[nodiscard]] net::ValueType type_of(const std::string& input) const {
    for (const auto& port : info_->inputs) {
      if (port.name == input) return port.type;
    }
    return net::ValueType::kBoolean;
  }
  template <class T>
  harness::Cell<T>* cell(const std::string& input) {
    const auto found = environment_.cells.find("harness-" + input);
    auto* typed = found == environment_.cells.end() ? nullptr : dynamic_cast<harness::Cell<T>*>(found->second.get());
    if (typed == nullptr) ADD_FAILURE() << "no settable input '" << input << "' of that type";
    return typed;
  }

  harness::CellEnvironment environment_;
  const net::PrimitiveInfo* info_ = nullptr;
  std::vector<const net::PrimitiveInfo::Port*> linked_;
  std::string prefix_;
  std::unique_ptr<net::CompiledNet> net_;
  Diagnostics diagnostics_;
};

/// What every primitive owes the net, tried with seeded values of every size: no allocation; null on an input that
/// propagates null makes every output null in the same cycle (inputs that break loops: one later); all inputs null is
/// survived; the first cycle after a reset equals that of a primitive just made, bit for bit; equal inputs give equal
/// bits.
inline void check_primitive_contract(const std::string& type,
                                     const nlohmann::ordered_json& parameters = nlohmann::ordered_json::object(),
                                     const HarnessOptions& options = {}) {
  SCOPED_TRACE("contract of " + type);
  constexpr int kCycles = 40;
  const auto feed = [](PrimitiveHarness& harness, Random& random) {
    for (const auto* input : harness.linked()) {
      if (random.unit() < 0.1) {
        harness.set_null(input->name);
      } else {
        harness.set_random(input->name, random);
      }
    }
  };
  PrimitiveHarness fresh(type, parameters, options), reset(type, parameters, options, true);
  ASSERT_TRUE(fresh.ready()) << fresh.diagnostics().to_string();
  ASSERT_TRUE(reset.ready()) << reset.diagnostics().to_string();

  // The reset one has lived a life before: both must then go on alike.
  Random before(1, type), first(2, type), second(2, type);
  reset.set("active", true);
  for (int i = 0; i < kCycles; ++i) {
    feed(reset, before);
    reset.step();
  }
  reset.set("active", false).step().set("active", true);
  for (int i = 0; i < kCycles && !fresh.signals().fail && !reset.signals().fail; ++i) {
    fresh.cycle.index = reset.cycle.index;
    fresh.cycle.time = reset.cycle.time;
    feed(fresh, first);
    feed(reset, second);
    fresh.step();
    reset.step();
    ASSERT_EQ(fresh.output_bytes(), reset.output_bytes())
        << "cycle " << i << " after the reset differs from that of a primitive just made: state must begin where "
        << "cycle.first is true";
  }

  const auto& breaking = fresh.info().loop_breaking_inputs;
  for (const auto* input : fresh.linked()) {
    if (input->spec.on_null != net::OnNull::kPropagate) continue;
    if (std::ranges::find(breaking, input->name) != breaking.end()) continue;
    PrimitiveHarness one(type, parameters, options);
    Random random(3, type);
    for (int i = 0; i < 5; ++i) {
      for (const auto* other : one.linked()) one.set_random(other->name, random);
      one.set_null(input->name).step();
      for (const auto& output : one.info().outputs) {
        EXPECT_TRUE(one.is_null(output.name)) << "null on '" << input->name << "' leaves '" << output.name
                                              << "' with a value, but the input does not declare on_null";
      }
    }
  }
  PrimitiveHarness nulls(type, parameters, options);
  nulls.step(3);
}

/// What once came in spoils nothing for ever (row N5): after inputs at the ends of what a double holds, ordinary ones
/// give null where they give it to a primitive just made, and nowhere else.
inline void check_recovery(const std::string& type, const nlohmann::ordered_json& parameters,
                           const HarnessOptions& options = {}) {
  SCOPED_TRACE("recovery of " + type);
  PrimitiveHarness spoiled(type, parameters, options), fresh(type, parameters, options);
  ASSERT_TRUE(spoiled.ready()) << spoiled.diagnostics().to_string();
  Random extreme(4, type), first(5, type), second(5, type);
  spoiled.step_random(60, extreme, harness::Numbers::kExtreme);
  if (spoiled.signals().fail || spoiled.signals().terminate) return;  // the net would have ended
  spoiled.step_random(400, first, harness::Numbers::kModerate);
  fresh.step_random(400, second, harness::Numbers::kModerate);
  for (const auto& output : fresh.info().outputs)
    EXPECT_EQ(spoiled.is_null(output.name), fresh.is_null(output.name)) << output.name;
}

/// LOAD's notes on null tell no lies: with ordinary inputs, none of them null, an output is null only where it says
/// may_be_null.
inline void check_declared_nulls(const std::string& type, const nlohmann::ordered_json& parameters,
                                 const HarnessOptions& options = {}) {
  SCOPED_TRACE("declared nulls of " + type);
  PrimitiveHarness harness(type, parameters, options);
  ASSERT_TRUE(harness.ready()) << harness.diagnostics().to_string();
  Random random(6, type);
  for (int i = 0; i < 60; ++i) {
    harness.step_random(1, random, harness::Numbers::kModerate);
    if (harness.signals().fail) return;  // the net has ended, with a cause
    for (const auto& output : harness.info().outputs) {
      if (output.spec.may_be_null) continue;
      ASSERT_FALSE(harness.is_null(output.name)) << output.name << " in cycle " << i;
    }
  }
}

}  // namespace takt::test
