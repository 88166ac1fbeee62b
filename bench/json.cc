// What the JSON reader costs: ms per MiB for documents of different shapes, those that attack it among them.
// bench_json [MIB]
#include "core/base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/object_reader.h"

using namespace takt;

namespace {

/// `open`, then what make(i) gives until there are `bytes`, then `close`.
template <class Make>
std::string filled(std::size_t bytes, const char* open, const char* close, Make make) {
  std::string text = open;
  for (std::size_t i = 0; text.size() < bytes; ++i) text += (i == 0 ? "" : ",") + make(i);
  return text + close;
}

struct Shape {
  const char* name;
  std::string text;
};

std::vector<Shape> shapes(std::size_t bytes) {
  const auto key = [](std::size_t i) { return fmt::format("\"key {}\":{}", i, i); };
  const auto number = [](std::size_t i) { return fmt::format("{:.15g}", 1.1234567890123 * static_cast<double>(i)); };
  const auto step = [](std::size_t i) {
    return fmt::format(R"({{"do":"lin","name":"step {}","to":{{"in":"world","position_m":[0.1,0.2,0.3]}}}})", i);
  };
  return {{"numbers in an array", filled(bytes, "[", "]", number)},
          {"steps of a program", filled(bytes, "[", "]", step)},
          {"one object of many keys", filled(bytes, "{", "}", key)},
          {"one key again and again", filled(bytes, "{", "}", [](std::size_t) { return std::string("\"a\":1"); })},
          {"empty arrays", filled(bytes, "[", "]", [](std::size_t) { return std::string("[]"); })},
          {"one text", "[\"" + std::string(bytes, 'x') + "\"]"},
          {"escapes", filled(bytes, "[", "]", [](std::size_t) { return std::string(R"("\u20ac\n\"")"); })},
          {"brackets without end", std::string(bytes, '[')}};
}

/// ms, the median of several.
template <class Work>
double median_ms(Work work) {
  std::vector<double> times;
  for (int i = 0; i < 9; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  std::ranges::sort(times);
  return times[times.size() / 2];
}

}  // namespace

int main(int count, char** words) {
  const double mib = count > 1 ? std::atof(words[1]) : 1.0;
  for (const Shape& shape : shapes(static_cast<std::size_t>(mib * (1 << 20)))) {
    const double size = static_cast<double>(shape.text.size()) / (1 << 20);
    const bool taken = parse_json(shape.text).has_value();
    const double ms = median_ms([&] { return parse_json(shape.text).has_value(); });
    fmt::print("{:<26} {:7.1f} ms per MiB{}\n", shape.name, ms / size, taken ? "" : "  (refused)");
  }
  return 0;
}
