#include "tests/fuzz/fuzz_target.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace {

/// A word in the format of libFuzzer: text with the quotes that JSON has around it, anything else byte by byte.
std::string dictionary_word(const std::string& word) {
  const auto is_text = [](unsigned char c) { return c >= 0x20 && c < 0x7f && c != '"' && c != '\\'; };
  if (std::all_of(word.begin(), word.end(), is_text)) return "\"\\\"" + word + "\\\"\"";
  std::string bytes = "\"";
  for (const unsigned char c : word) {
    constexpr char kDigits[] = "0123456789abcdef";
    bytes += std::string("\\x") + kDigits[c >> 4] + kDigits[c & 15];
  }
  return bytes + "\"";
}

/// As `--dictionary`, the first argument of a fuzz program, asks for it: words in the format of libFuzzer.
void print_dictionary_if_asked(int argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]) != "--dictionary") return;
  for (const std::string& word : takt::test::fuzz_target().words) std::puts(dictionary_word(word).c_str());
  std::exit(0);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  print_dictionary_if_asked(*argc, *argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  takt::test::fuzz_target().load({reinterpret_cast<const char*>(data), size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t capacity);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t capacity,
                                               unsigned int seed) {
  const takt::test::FuzzTarget& target = takt::test::fuzz_target();
  takt::Random random(seed, "mutator");
  if (random.unit() < target.share) {
    const auto changed = target.mutate({reinterpret_cast<const char*>(data), size}, random);
    if (changed && changed->size() <= capacity) {
      std::copy(changed->begin(), changed->end(), data);
      return changed->size();
    }
  }
  return LLVMFuzzerMutate(data, size, capacity);
}
