#include "core/program/tree/outcome_json.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::pair<Outcome, const char*> kOutcomes[] = {
    {Outcome::kDone, "done"}, {Outcome::kFailed, "failed"}, {Outcome::kStopped, "stopped"}};

}  // namespace

Json outcome_to_json(Outcome outcome) {
  return std::ranges::find(kOutcomes, outcome, &std::pair<Outcome, const char*>::first)->second;
}

Outcome outcome_from_json(const Json& json) {
  const auto* found = std::ranges::find_if(kOutcomes, [&json](const auto& one) { return json == one.second; });
  if (found == std::end(kOutcomes)) throw std::out_of_range("there is no such result");
  return found->first;
}

Json diagnostics_to_json(const Diagnostics& diagnostics) {
  Json list = Json::array();
  for (const Diagnostic& one : diagnostics.list())
    list.push_back({{"severity", one.severity},
                    {"code", name_of(one.code)},
                    {"pointer", one.pointer},
                    {"text", one.message},
                    {"hint", one.hint}});
  return list;
}

Diagnostics diagnostics_from_json(const Json& json) {
  Diagnostics diagnostics;
  for (const Json& one : json) {
    diagnostics.add({.severity = one.at("severity").get<Severity>(),
                     .code = code_named(one.at("code").get<std::string>()).value_or(Code::kInternal),
                     .file = {},
                     .pointer = one.at("pointer").get<std::string>(),
                     .message = one.at("text").get<std::string>(),
                     .hint = one.at("hint").get<std::string>()});
  }
  return diagnostics;
}

}  // namespace takt::program
