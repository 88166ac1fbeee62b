// Programs with the traces that they have to have. A file holds several: each begins with a line `;@ NAME`, has its
// inputs in lines `;< TIME INPUT VALUE`, its source, perhaps its data list, and its trace in lines `;> TEXT`.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/languages/krl/trace_host.h"

namespace takt::languages::krl::test {
namespace {

struct Example {
  std::string name, file;
  ModuleText text;
  std::vector<TraceHost::Change> changes;
  std::vector<std::string> trace;
  bool with_times = false;
};

std::vector<Example> read_examples(const std::filesystem::path& file) {
  std::vector<Example> all;
  std::ifstream in(file);
  bool in_data = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(";@ ")) {
      all.push_back({});
      all.back().name = line.substr(3);
      all.back().file = file.filename().string();
      all.back().text = {"MAIN", "main.src", "", "main.dat", ""};
      in_data = false;
      continue;
    }
    if (all.empty()) continue;
    Example& one = all.back();
    if (line.starts_with(";< ")) {
      TraceHost::Change change;
      std::istringstream(line.substr(3)) >> change.at >> change.input >> change.value;
      one.changes.push_back(change);
    } else if (line == ";times") {
      one.with_times = true;
    } else if (line.starts_with(";> ")) {
      one.trace.push_back(line.substr(3));
    } else {
      in_data = in_data || line.starts_with("DEFDAT");
      (in_data ? one.text.data : one.text.source) += line + "\n";
    }
  }
  return all;
}

std::vector<Example> all_examples() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator("tests/languages/krl/corpus"))
    files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<Example> all;
  for (const auto& file : files) std::ranges::move(read_examples(file), std::back_inserter(all));
  return all;
}

/// What a program does, or why it cannot: "refused: CODE LINE:COLUMN", "failed: CODE LINE".
std::vector<std::string> trace_of(const Example& one) {
  const auto program = compile({one.text}, {"GRIP"});
  std::vector<std::string> trace;
  if (!program) {
    for (const Diagnostic& each : program.error().list())
      trace.push_back(fmt::format("refused: {} {}:{}", name_of(each.code), each.line, each.column));
    return trace;
  }
  TraceHost host(one.changes);
  host.with_times = one.with_times;
  Machine machine(**program, host);
  const Machine::Progress progress = host.run(machine);
  trace = host.trace();
  if (progress == Machine::Progress::kRunning) trace.emplace_back("runs on");
  if (progress == Machine::Progress::kHalted) trace.emplace_back("halted");
  if (progress == Machine::Progress::kFailed)
    for (const Diagnostic& each : machine.diagnostics().list())
      trace.push_back(fmt::format("failed: {} {}", name_of(each.code), each.line));
  return trace;
}

TEST(KrlCorpus, EachProgramHasItsTrace) {
  const auto examples = all_examples();
  EXPECT_GE(examples.size(), 60u);
  for (const Example& one : examples) {
    std::string wanted, found;
    for (const std::string& line : one.trace) wanted += ";> " + line + "\n";
    for (const std::string& line : trace_of(one)) found += ";> " + line + "\n";
    EXPECT_EQ(found, wanted) << one.file << ": " << one.name;
  }
}

TEST(KrlCorpus, TheSameProgramDoesTheSameAgain) {
  for (const Example& one : all_examples()) EXPECT_EQ(trace_of(one), trace_of(one)) << one.name;
}

TEST(KrlCorpus, PrintedAndReadAgainItIsTheSame) {
  for (Example one : all_examples()) {
    Diagnostics wrong;
    const Module module = parse_module(one.text, wrong);
    if (wrong.has_errors()) continue;
    one.text.source = print_source(module);
    one.text.data = print_data(module);
    const Module again = parse_module(one.text, wrong);
    EXPECT_TRUE(wrong.empty()) << one.name << "\n" << wrong.to_string() << one.text.source;
    EXPECT_EQ(print_source(again), one.text.source) << one.name;
    EXPECT_EQ(print_data(again), one.text.data) << one.name;
  }
}

}  // namespace
}  // namespace takt::languages::krl::test
