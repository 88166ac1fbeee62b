// Any bytes as a scenario lead to a cell that is ready to run, or to findings with reasons.
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "scenario/session.h"
#include "tests/fuzz/promise.h"
#include "tests/support/json_mutator.h"

namespace takt {
namespace {

std::vector<std::string> scenario_words() {
  std::vector<std::string> words;
  for (const auto& entry : std::filesystem::directory_iterator("scenarios")) {
    const auto json = entry.path().extension() == ".json" ? read_json(entry.path()) : failure("", "no scenario");
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
  auto description = scenario::parse_description(text);
  if (!description) return test::expect_reasons(description.error());
  const auto session = scenario::Session::create(std::move(*description), models);
  if (!session) test::expect_reasons(session.error());
}

}  // namespace
}  // namespace takt

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  takt::test::print_dictionary_if_asked(*argc, *argv, takt::words());
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  takt::load({reinterpret_cast<const char*>(data), size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t capacity);

/// A tenth of the time bytes, else values and keys.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t capacity,
                                               unsigned int seed) {
  takt::Random random(seed, "mutator");
  if (random.unit() < 0.9) {
    const auto document = takt::parse_json({reinterpret_cast<const char*>(data), size});
    if (document) {
      const std::string text = takt::test::mutated_json(*document, takt::words(), random);
      if (text.size() <= capacity) {
        std::copy(text.begin(), text.end(), data);
        return text.size();
      }
    }
  }
  return LLVMFuzzerMutate(data, size, capacity);
}
