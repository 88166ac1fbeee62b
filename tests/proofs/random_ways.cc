#include "tests/proofs/random_ways.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::test {

using Json = nlohmann::ordered_json;

namespace {

constexpr int kParts = 14, kSources = 3, kMonitors = 5;
constexpr long kMostSteps = 200'000;

bool is_sink(const std::string& type) { return type == "ProofSink"; }
bool has_value(const std::string& type) { return !is_sink(type) && type != "ProofSwitch"; }

}  // namespace

RandomWays::RandomWays(Random& random) {
  fragments_.push_back({});
  for (int i = 0; i < kSources; ++i) add("ProofEvent", 0, 0, 0, random);
  for (int i = 0; i < kParts; ++i) add_part(random, 0);
  for (int i = 0; i < kMonitors; ++i) add("ProofSink", 0, 0, 1, random);
  close_loops(random);
  list_edges();
  describe(random);
}

int RandomWays::add(std::string type, int fragment, int latency, int inputs, Random& random) {
  const int number = static_cast<int>(parts_.size());
  const auto same = [&](const Part& part) { return part.type == type; };
  const char first = type == "ProofEvent" ? 'e' : is_sink(type) ? 'm' : type == "ProofSwitch" ? 's' : 'r';
  // Sources and monitors are numbered from 0; the others have a letter before that mixes up the order of evaluation.
  const std::string id = first == 'e' || first == 'm'
                             ? fmt::format("{}{}", first, std::ranges::count_if(parts_, same))
                             : fmt::format("{}{}{}", static_cast<char>('n' + random.bits() % 12), first, number);
  const std::string& scope = fragments_[static_cast<std::size_t>(fragment)].id;
  parts_.push_back({scope.empty() ? id : scope + "/" + id, std::move(type), fragment, latency,
                    std::vector<Feed>(static_cast<std::size_t>(inputs), Feed{-1, 0})});
  if (inputs > 0) feed(number, random);
  return number;
}

void RandomWays::feed(int part, Random& random) {
  for (std::size_t input = 0; input < parts_[static_cast<std::size_t>(part)].inputs.size(); ++input) {
    const int breaks = parts_[static_cast<std::size_t>(part)].type == "ProofPrevious" ? 1 : 0;
    if (random.unit() < 0.12 && !is_sink(parts_[static_cast<std::size_t>(part)].type)) {
      open_.emplace_back(part, static_cast<int>(input));
      continue;
    }
    int from = 0;
    do {
      from = static_cast<int>(random.bits() % static_cast<std::uint64_t>(part));
    } while (!has_value(parts_[static_cast<std::size_t>(from)].type));
    const int delayed = random.unit() < 0.2 ? 1 : 0;
    parts_[static_cast<std::size_t>(part)].inputs[input] = {from, std::max(breaks, delayed)};
  }
}

/// What waits is fed one cycle late, from anywhere.
void RandomWays::close_loops(Random& random) {
  for (const auto& [part, input] : open_) {
    int from = 0;
    do {
      from = static_cast<int>(random.bits() % parts_.size());
    } while (!has_value(parts_[static_cast<std::size_t>(from)].type));
    parts_[static_cast<std::size_t>(part)].inputs[static_cast<std::size_t>(input)] = {from, 1};
  }
}

void RandomWays::add_part(Random& random, int fragment) {
  const double kind = random.unit();
  const bool deep = fragment != 0 && fragments_[static_cast<std::size_t>(fragment)].parent != 0;
  if (kind < 0.12 && !deep) {
    add_fragment(random, fragment);
  } else if (kind < 0.22) {
    static constexpr std::array<int, 3> kLatencies = {1, 2, 7};
    const int latency = kLatencies[random.bits() % kLatencies.size()];
    add(fmt::format("ProofLag{}", latency), fragment, latency, 1, random);
  } else if (kind < 0.28) {
    add("ProofPrevious", fragment, 0, 1, random);
  } else {
    add("ProofRoute", fragment, 0, 2, random);
  }
}

void RandomWays::add_fragment(Random& random, int parent) {
  Fragment fragment;
  const std::string& scope = fragments_[static_cast<std::size_t>(parent)].id;
  fragment.id = fmt::format("{}f{}", scope.empty() ? "" : scope + "/", fragments_.size());
  fragment.parent = parent;
  if (random.unit() < 0.5) {
    fragment.switch_part = add("ProofSwitch", parent, 0, 1, random);
    fragment.switch_cycles = random.unit() < 0.3 ? 1 : 0;
    ++switched_fragments;
  }
  fragments_.push_back(fragment);
  const int number = static_cast<int>(fragments_.size()) - 1;
  for (int i = 1 + static_cast<int>(random.bits() % 3); i > 0; --i) add_part(random, number);
}

void RandomWays::list_edges() {
  edges_.resize(parts_.size());
  for (int p = 0; p < static_cast<int>(parts_.size()); ++p) {
    const Part& part = parts_[static_cast<std::size_t>(p)];
    for (std::size_t i = 0; i < part.inputs.size(); ++i) {
      const Feed& from = part.inputs[i];
      edges_[static_cast<std::size_t>(from.from)].push_back({p, static_cast<int>(i), from.cycles + part.latency});
      has_loop = has_loop || from.from >= p;
    }
    for (int f = part.fragment; f > 0; f = fragments_[static_cast<std::size_t>(f)].parent) {
      const Fragment& fragment = fragments_[static_cast<std::size_t>(f)];
      if (fragment.switch_part < 0) continue;
      // A part that comes to life begins at once, and is as late as ever with what it reads from then on.
      auto& edges = edges_[static_cast<std::size_t>(fragment.switch_part)];
      edges.push_back({p, kActivity, fragment.switch_cycles});
      if (part.latency > 0) edges.push_back({p, kActivity, fragment.switch_cycles + part.latency});
    }
  }
}

net::NetDescription& RandomWays::net_of(int fragment) {
  if (fragment == 0) return net;
  const Fragment& own = fragments_[static_cast<std::size_t>(fragment)];
  const std::string name = own.id.substr(own.id.rfind('/') + 1);
  for (net::FragmentDescription& f : net_of(own.parent).fragments) {
    if (f.id == name) return f.net;
  }
  std::abort();
}

std::string RandomWays::local_id(const Part& part) const { return part.id.substr(part.id.rfind('/') + 1); }

void RandomWays::describe(Random& random) {
  for (std::size_t f = 1; f < fragments_.size(); ++f) {
    const std::string& id = fragments_[f].id;
    net_of(fragments_[f].parent)
        .fragments.push_back({id.substr(id.rfind('/') + 1),
                              random.unit() < 0.5 ? net::WhenInactive::kKeep : net::WhenInactive::kReset,
                              {},
                              {},
                              {}});
  }
  net.add("end", "TestEnd");
  for (const Part& part : parts_) net_of(part.fragment).add(local_id(part), part.type);
  for (const Part& part : parts_) {
    for (std::size_t i = 0; i < part.inputs.size(); ++i) {
      const Part& from = parts_[static_cast<std::size_t>(part.inputs[i].from)];
      const std::string port = is_sink(part.type) ? "in" : i == 0 ? "a" : "b";
      const bool same = from.fragment == part.fragment;
      net::NetDescription& scope = same ? net_of(part.fragment) : net;
      const std::string source = (same ? local_id(from) : from.id) + ".out";
      const std::string target = (same ? local_id(part) : part.id) + "." + port;
      if (part.inputs[i].cycles > 0 && part.type != "ProofPrevious") {
        scope.link_delayed(source, target, 0.0);
      } else {
        scope.link(source, target);
      }
    }
  }
  for (std::size_t f = 1; f < fragments_.size(); ++f) {
    const Fragment& fragment = fragments_[f];
    if (fragment.switch_part < 0) continue;
    const std::string source = local_id(parts_[static_cast<std::size_t>(fragment.switch_part)]) + ".out";
    const std::string target = fragment.id.substr(fragment.id.rfind('/') + 1) + ".active";
    if (fragment.switch_cycles > 0) {
      net_of(fragment.parent).link_delayed(source, target, false);
    } else {
      net_of(fragment.parent).link(source, target);
    }
  }
}

int RandomWays::number_of(const std::string& id) const {
  const auto found = std::ranges::find(parts_, id, &Part::id);
  return found == parts_.end() ? -1 : static_cast<int>(found - parts_.begin());
}

Ways RandomWays::search(int source, int sink) const {
  // Only parts that lead on to the sink are worth a step.
  std::vector<bool> leads(parts_.size(), false);
  leads[static_cast<std::size_t>(sink)] = true;
  for (bool more = true; more;) {
    more = false;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      if (leads[p]) continue;
      leads[p] = std::ranges::any_of(edges_[p], [&](const Edge& e) { return leads[static_cast<std::size_t>(e.to)]; });
      more = more || leads[p];
    }
  }
  Ways ways;
  Way way{{source, 0}};
  std::vector<bool> passed(parts_.size(), false);
  long steps = 0;
  int fewest = 0, most = -1;
  const auto walk = [&](const auto& self, int part, int cycles) -> void {
    if (part == sink) {
      if (ways.shortest.empty() || cycles < fewest) fewest = cycles, ways.shortest = way;
      if (cycles > most) most = cycles, ways.longest = way;
      return;
    }
    passed[static_cast<std::size_t>(part)] = true;
    for (const Edge& edge : edges_[static_cast<std::size_t>(part)]) {
      if (!leads[static_cast<std::size_t>(edge.to)] || passed[static_cast<std::size_t>(edge.to)]) continue;
      if (++steps > kMostSteps) {
        ways.complete = false;
        break;
      }
      way.push_back({edge.to, edge.input});
      self(self, edge.to, cycles + edge.cycles);
      way.pop_back();
    }
    passed[static_cast<std::size_t>(part)] = false;
  };
  walk(walk, source, 0);
  return ways;
}

Json& RandomWays::parameters(int part) {
  const Part& own = parts_[static_cast<std::size_t>(part)];
  net::NetDescription& scope = net_of(own.fragment);
  return std::ranges::find(scope.primitives, local_id(own), &net::PrimitiveDescription::id)->parameters;
}

void RandomWays::set_event(int source, std::int64_t cycle) { parameters(source)["at"] = cycle; }

void RandomWays::choose_at_random(Random& random) {
  static constexpr std::array<const char*, 3> kModes = {"on", "always", "off"};
  for (int p = 0; p < static_cast<int>(parts_.size()); ++p) {
    const std::string& type = parts_[static_cast<std::size_t>(p)].type;
    if (type == "ProofRoute") parameters(p)["way"] = static_cast<int>(random.bits() % 2);
    if (type != "ProofSwitch") continue;
    parameters(p)["mode"] = kModes[random.bits() % (leads_to_itself(p) ? 2 : 3)];
    parameters(p)["sees"] = random.unit() < 0.5 ? "above" : "there";
  }
}

void RandomWays::choose(const Way& way) {
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Part& part = parts_[static_cast<std::size_t>(way[i].part)];
    if (way[i].input != kActivity && part.type == "ProofRoute") parameters(way[i].part)["way"] = way[i].input;
    for (int f = part.fragment; f > 0; f = fragments_[static_cast<std::size_t>(f)].parent) {
      const int by = fragments_[static_cast<std::size_t>(f)].switch_part;
      if (by >= 0) parameters(by)["mode"] = "always";
    }
  }
  for (std::size_t i = 1; i < way.size(); ++i) {
    if (way[i].input != kActivity) continue;
    // What is passed inside the fragment before must live until then: the event switches it off.
    const int by = way[i - 1].part;
    const bool lived = std::any_of(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(i),
                                   [&](const Step& step) { return is_switched(step.part, by); });
    parameters(by)["mode"] = lived ? "off" : "on";
  }
}

bool RandomWays::may_blink() {
  for (int p = 0; p < static_cast<int>(parts_.size()); ++p) {
    if (parts_[static_cast<std::size_t>(p)].type != "ProofSwitch" || !leads_to_itself(p)) continue;
    if (parameters(p).value("mode", "always") == "off") return true;
  }
  return false;
}

/// Whether there is a way from the part back to it.
bool RandomWays::leads_to_itself(int part) const {
  std::vector<bool> reached(parts_.size(), false);
  std::vector<int> pending{part};
  while (!pending.empty()) {
    const int from = pending.back();
    pending.pop_back();
    for (const Edge& edge : edges_[static_cast<std::size_t>(from)]) {
      if (edge.to == part) return true;
      if (!reached[static_cast<std::size_t>(edge.to)]) pending.push_back(edge.to);
      reached[static_cast<std::size_t>(edge.to)] = true;
    }
  }
  return false;
}

/// Whether the part lies in a fragment that this switch switches.
bool RandomWays::is_switched(int part, int by) const {
  for (int f = parts_[static_cast<std::size_t>(part)].fragment; f > 0;
       f = fragments_[static_cast<std::size_t>(f)].parent) {
    if (fragments_[static_cast<std::size_t>(f)].switch_part == by) return true;
  }
  return false;
}

std::string RandomWays::text() const { return "\n" + net::net_to_json(net).dump(1); }

}  // namespace takt::test
