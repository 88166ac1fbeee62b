#include "tests/core/net/random_net.h"

#include <map>

#include <fmt/format.h>

#include "core/net/registry.h"

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

struct Output {
  std::string port;  ///< as the net at hand names it
  ValueType type;
  int age;  ///< when it was made; links from older to younger ones need no delay
};

/// Builds one net; a fragment is built by one of its own, with the outer outputs handed in as ports.
class Generator {
 public:
  Generator(Random& random, NetDescription& net, int depth) : random_(random), net_(net), depth_(depth) {}

  void run(int primitives) {
    for (int i = 0; i < primitives; ++i) {
      if (depth_ < 3 && chance(0.06)) {
        add_fragment(i);
      } else if (depth_ < 3 && chance(0.04)) {
        add_turns(i);
      } else {
        add_primitive(i);
      }
    }
    for (const auto& [port, type] : waiting_) {
      if (const Output* source = any(type)) net_.link_delayed(source->port, port, initial(type));
    }
    // An input that found no source in the whole net gets a constant.
    for (const auto& [port, type] : waiting_) {
      if (any(type) == nullptr) set_constant(port, type);
    }
    add_demands();
  }

  /// Half of the nets end some time, or would.
  void link_end(const std::string& port) {
    const Output* source = any(ValueType::kBoolean);
    if (source != nullptr && chance(0.5)) net_.link(source->port, port);
  }

  std::vector<Output> outputs;
  FragmentDescription* fragment = nullptr;  ///< of the net that is built; nullptr at the top
  Generator* outer = nullptr;

 private:
  bool chance(double p) { return random_.unit() < p; }
  std::size_t below(std::size_t n) { return random_.bits() % n; }

  std::string fresh_id() { return fmt::format("{}{}", static_cast<char>('a' + below(26)), ids_++); }

  void add_primitive(int age) {
    static const std::vector<std::string> kTypes = {
        "TestAdd",    "TestMultiply", "TestDivide",   "TestSum",      "TestConstant", "TestCounter",
        "TestToReal", "TestGreater",  "TestPrevious", "TestAllTypes", "TestCompose",  "TestPose",
        "TestAdd",    "TestSum",      "TestExtremes", "TestLatch",    "TestAnd",      "TestElse"};
    const std::string& type = kTypes[below(kTypes.size())];
    const PrimitiveInfo& info = *Registry::global().find(type);
    const std::string id = fresh_id();
    Json parameters = Json::object();
    if (type == "TestConstant") parameters["value"] = random_.uniform(-3.0, 3.0);
    if (type == "TestCounter") parameters["null_every"] = 2 + static_cast<int>(below(9));
    net_.add(id, type, parameters);
    for (const std::string& flag : info.flags) {
      if (chance(0.5)) net_.primitives.back().on_null[flag] = chance(0.5);
    }
    for (const auto& input : info.inputs) feed(id + "." + input.name, input, info, age);
    for (const auto& output : info.outputs) outputs.push_back({id + "." + output.name, output.type, age});
  }

  void feed(const std::string& port, const PrimitiveInfo::Port& input, const PrimitiveInfo&, int) {
    if (input.spec.optional && chance(0.4)) return;
    if (chance(0.15)) return set_constant(port, input.type);
    if (chance(0.15)) {
      waiting_.emplace_back(port, input.type);  // delayed, from anywhere, so it may close a loop
      return;
    }
    const Output* source = any(input.type);
    if (source == nullptr && outer != nullptr) {
      if (link_from_outside(port, input.type)) return;
    }
    if (source == nullptr || (outer != nullptr && chance(0.3) && link_from_outside(port, input.type))) {
      if (source == nullptr) set_constant(port, input.type);
      return;
    }
    if (chance(0.1)) {
      net_.link_delayed(source->port, port, initial(input.type));
    } else {
      net_.link(source->port, port);
    }
  }

  /// A port of this fragment, fed by the net around it.
  bool link_from_outside(const std::string& port, ValueType type) {
    const Output* source = outer->any(type);
    if (source == nullptr) return false;
    const std::string name = fmt::format("in{}", fragment->inputs.size());
    fragment->inputs.emplace_back(name, port);
    const std::string to = fragment->id + "." + name;
    if (chance(0.2)) {
      outer->net_.link_delayed(source->port, to, initial(type));
    } else {
      outer->net_.link(source->port, to);
    }
    return true;
  }

  void add_fragment(int age) {
    FragmentDescription f;
    f.id = fresh_id();
    f.when_inactive = chance(0.5) ? WhenInactive::kKeep : WhenInactive::kReset;
    Generator inner(random_, f.net, depth_ + 1);
    inner.fragment = &f;
    inner.outer = this;
    inner.run(2 + static_cast<int>(below(8)));
    for (const Output& output : inner.outputs) {
      if (chance(0.5)) continue;
      const std::string name = fmt::format("out{}", f.outputs.size());
      f.outputs.emplace_back(name, output.port);
      outputs.push_back({f.id + "." + name, output.type, age});
    }
    if (chance(0.7)) activity(f);
    net_.fragments.push_back(std::move(f));
  }

  /// Two fragments that take turns, by a condition and its opposite, and meet at a Merge.
  void add_turns(int age) {
    const Output* condition = any(ValueType::kBoolean);
    if (condition == nullptr) return;
    const std::string active = condition->port, opposite = fresh_id(), merge = fresh_id();
    net_.add(opposite, "TestNot").link(active, opposite + ".in").add(merge, "TestMerge");
    const std::string actives[] = {active, opposite + ".out"};
    for (int i = 0; i < 2; ++i) {
      FragmentDescription f;
      f.id = fresh_id();
      f.when_inactive = chance(0.5) ? WhenInactive::kKeep : WhenInactive::kReset;
      f.net.add("sum", "TestSum", {{"in", random_.uniform(-1.0, 1.0)}});
      f.outputs.emplace_back("out", "sum.out");
      net_.link(actives[i], f.id + ".active").link(f.id + ".out", fmt::format("{}.input_{}", merge, i + 1));
      net_.fragments.push_back(std::move(f));
    }
    outputs.push_back({merge + ".out", ValueType::kReal, age});
  }

  /// Bounds along links, so wide that every net keeps them.
  void add_demands() {
    for (const LinkDescription& link : net_.links) {
      if (!chance(0.05)) continue;
      net_.demand(link.from, link.to, 1'000'000);
      if (chance(0.5)) net_.demands.back().minimum_cycles = 0;
    }
  }

  void activity(const FragmentDescription& f) {
    // Most fragments come and go: a reset that is left out shows only in the second activation.
    if (chance(0.6)) {
      const std::string id = fresh_id();
      net_.add(id, "TestBlink", {{"on", 1 + static_cast<int>(below(5))}, {"off", 1 + static_cast<int>(below(4))}});
      net_.link(id + ".out", f.id + ".active");
      return;
    }
    std::vector<const Output*> choices;
    for (const Output& output : outputs) {
      if (output.type == ValueType::kBoolean && !output.port.starts_with(f.id + ".")) choices.push_back(&output);
    }
    if (choices.empty()) return;
    const std::string& source = choices[below(choices.size())]->port;
    if (chance(0.3)) {
      net_.link_delayed(source, f.id + ".active", initial(ValueType::kBoolean));
    } else {
      net_.link(source, f.id + ".active");
    }
  }

  const Output* any(ValueType type) {
    std::vector<const Output*> choices;
    for (const Output& output : outputs) {
      if (output.type == type) choices.push_back(&output);
    }
    return choices.empty() ? nullptr : choices[below(choices.size())];
  }

  Json initial(ValueType type) { return chance(0.5) ? Json(nullptr) : value(type); }

  Json value(ValueType type) {
    switch (type) {
      case ValueType::kBoolean:
        return chance(0.5);
      case ValueType::kInteger:
        return static_cast<std::int64_t>(below(7)) - 3;
      case ValueType::kReal:
        return chance(0.2) ? Json(chance(0.5) ? -0.0 : 1e308) : Json(random_.uniform(-2.0, 2.0));
      case ValueType::kString:
        return fmt::format("text {}", below(4));
      case ValueType::kVector:
        return {random_.unit(), random_.unit(), -0.0};
      case ValueType::kRotation:
        return {0.6, 0.8, 0.0, -0.0};
      case ValueType::kFrame:
        return {{"position", {random_.unit(), 0, 1}}, {"quaternion", {0.6, 0, 0.8, 0}}};
      case ValueType::kTwist:
        return {{"linear", {1, 2, random_.unit()}}};
      case ValueType::kWrench:
        return {{"torque", {random_.unit(), 2, 3}}};
      case ValueType::kJoints:
        break;
    }
    return std::vector<double>(below(8), random_.unit());
  }

  void set_constant(const std::string& port, ValueType type) {
    const std::size_t dot = port.rfind('.');
    for (PrimitiveDescription& p : net_.primitives) {
      if (p.id == port.substr(0, dot)) p.parameters[port.substr(dot + 1)] = initial(type);
    }
  }

  Random& random_;
  NetDescription& net_;
  int depth_;
  int ids_ = 0;
  std::vector<std::pair<std::string, ValueType>> waiting_;
};

template <class T>
void shuffle(std::vector<T>& list, Random& random) {
  for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random.bits() % i]);
}

}  // namespace

NetDescription random_net(Random& random, int primitives) {
  NetDescription net;
  net.name = "random";
  Generator generator(random, net, 0);
  generator.run(primitives);
  net.add("end", "TestEnd");
  generator.link_end("end.in");
  return net;
}

NetDescription shuffled(const NetDescription& net, Random& random) {
  NetDescription other = net;
  std::vector<NetDescription*> pending{&other};
  while (!pending.empty()) {
    NetDescription& one = *pending.back();
    pending.pop_back();
    shuffle(one.primitives, random);
    shuffle(one.links, random);
    shuffle(one.fragments, random);
    for (FragmentDescription& f : one.fragments) {
      shuffle(f.inputs, random);
      shuffle(f.outputs, random);
      pending.push_back(&f.net);
    }
  }
  return other;
}

}  // namespace takt::net
