// Any bytes as a scenario lead to a cell that is ready to run, or to diagnostics with reasons.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "cell/run/session.h"
#include "core/base/json.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/support/json_mutator.h"

namespace takt {
namespace {

std::vector<std::string> scenario_words() {
  std::vector<std::string> words;
  for (const auto& entry : std::filesystem::directory_iterator("scenarios")) {
    const auto json =
        entry.path().extension() == ".json" ? read_json(entry.path()) : failure(Code::kNotFound, "", "no scenario");
    if (!json) continue;
    for (std::string& word : test::words_of(*json))
      if (word.size() < 40) words.push_back(std::move(word));
  }
  return words;
}

const std::vector<std::string>& words() {
  static const std::vector<std::string> all = scenario_words();
  return all;
}

void load(std::string_view text) {
  static const device::ModelLibrary models({"models"});
  auto description = cell::parse_description(text);
  if (!description) return test::expect_reasons(description.error());
  const auto session = cell::Session::create(std::move(*description), models);
  if (!session) test::expect_reasons(session.error());
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{.words = words(),
                                 .load = load,
                                 .share = 0.9,
                                 .mutate = [](std::string_view input, Random& random) -> std::optional<std::string> {
                                   const auto document = parse_json(input);
                                   if (!document) return std::nullopt;
                                   return mutated_json(*document, words(), random);
                                 }};
  return target;
}

}  // namespace takt::test
