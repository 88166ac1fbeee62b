// Ticks trees whose leaves do what their patterns say, and prints what happened: for behavior_tree_oracle.py.
//
// Input, a document per line: {"xml": TEXT, "ticks": N, "leaves": {NAME: ["2S", "0F", ...]}, "entries": {NAME: NUMBER
// OR TEXT}}. The k-th start of a leaf of a name follows the k-th pattern, cyclically: how many ticks it runs, and how
// it ends. Output, a line each: {"ticks": [[STATUS, EVENT, ...], ...], "entries": {NAME: NUMBER OR TEXT}}, or {"error":
// TEXT}.
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "languages/behavior_tree/session.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

class PatternLeaves final : public TreeLeaves {
 public:
  explicit PatternLeaves(const Json& patterns) : patterns_(patterns) {}

  std::vector<std::string> events;

  TreeStatus tick(std::size_t number, const TreeLeaf& leaf, bool fresh) override {
    const std::string& name = leaf.spec->type;
    Running& one = running_[number];
    if (fresh) {
      const Json& all = patterns_.at(name);
      const auto pattern = all[started_[name]++ % all.size()].get<std::string>();
      one = {pattern[0] - '0', pattern[1] == 'S' ? TreeStatus::kSuccess : TreeStatus::kFailure};
      events.push_back("start " + name);
    } else {
      --one.left;
      events.push_back("run " + name);
    }
    return one.left > 0 ? TreeStatus::kRunning : one.end;
  }
  void halt(std::size_t, const TreeLeaf& leaf) override { events.push_back("halt " + leaf.spec->type); }

 private:
  struct Running {
    int left = 0;
    TreeStatus end = TreeStatus::kSuccess;
  };
  const Json& patterns_;
  std::map<std::string, std::size_t> started_;
  std::map<std::size_t, Running> running_;
};

Json trace(const Json& task) {
  const auto file = read_trees(task.at("xml").get<std::string>());
  if (!file) return {{"error", file.error().to_string()}};
  PatternLeaves leaves(task.at("leaves"));
  TreeSession session(**file, leaves);
  for (const auto& [name, value] : task.at("entries").items())
    session.board().set(name, value.is_string() ? TreeValue{value.get<std::string>()} : TreeValue{value.get<double>()});
  Json ticks = Json::array();
  for (int i = 0; i < task.at("ticks").get<int>(); ++i) {
    leaves.events.clear();
    Json tick = Json::array({std::string(name_of(session.tick(i * kMillisecond)))});
    for (const std::string& event : leaves.events) tick.push_back(event);
    ticks.push_back(std::move(tick));
    if (session.error()) return {{"error", session.error()->message}};
  }
  Json entries = Json::object();
  for (const auto& [name, value] : task.at("entries").items()) {
    const TreeValue& now = *session.board().find(name);
    entries[name] = now.is_number() ? Json(now.number()) : Json(now.text());
  }
  return {{"ticks", std::move(ticks)}, {"entries", std::move(entries)}};
}

}  // namespace
}  // namespace takt::languages

int main() {
  for (std::string line; std::getline(std::cin, line);)
    std::cout << takt::languages::trace(nlohmann::ordered_json::parse(line)).dump() << "\n";
  return 0;
}
