// Files that nobody would write: our scenarios with a few values lost, doubled, misspelt or moved. Each is a cell that
// is ready to run, or is refused with reasons and places. Coverage-guided, with sanitizers:
// tests/fuzz/fuzz_scenario.cc.
#include <filesystem>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/run/session.h"
#include "core/base/json.h"
#include "tests/support/json_mutator.h"
#include "tests/support/random_runs.h"

namespace takt::cell::mutated_files_test {
namespace {

TEST(Mutated, ScenariosAreReadyOrRefusedWithReasons) {
  const device::ModelLibrary models({"models"});
  std::vector<nlohmann::ordered_json> files;
  std::vector<std::string> words;
  for (const char* name : {"touch", "pick", "sort", "wave", "blend", "search", "can", "screw", "carry"}) {
    const auto json = read_json(std::string("scenarios/") + name + ".json");
    ASSERT_TRUE(json) << json.error().to_string();
    files.push_back(*json);
    for (std::string& word : takt::test::words_of(*json))
      if (word.size() < 40) words.push_back(std::move(word));
  }
  const takt::test::RandomRuns runs(700);
  int ready = 0, refused = 0;
  for (long i = 0; i < runs.count; ++i) {
    Random random(runs.first_seed + static_cast<std::uint64_t>(i), "mutated scenario");
    const std::string text = takt::test::mutated_json(files[random.bits() % files.size()], words, random);
    SCOPED_TRACE(text);
    // A process that ends without a word leaves the file in build/.
    std::ofstream("build/mutated-last.json") << text;
    auto description = parse_description(text);
    Diagnostics diagnostics = description ? Diagnostics{} : description.error();
    if (description) {
      const auto session = Session::create(std::move(*description), models);
      if (!session) diagnostics = session.error();
    }
    ready += !diagnostics.has_errors();
    refused += diagnostics.has_errors();
    for (const Diagnostic& diagnostic : diagnostics.list()) EXPECT_FALSE(diagnostic.message.empty());
  }
  std::printf("%d ready, %d refused\n", ready, refused);
  EXPECT_GT(ready, runs.count / 20);
  EXPECT_GT(refused, runs.count / 4);
}

}  // namespace
}  // namespace takt::cell::mutated_files_test
