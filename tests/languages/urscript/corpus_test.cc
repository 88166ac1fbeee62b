// Programs with the traces that they have to have. A file holds several: each begins with a line `#@ NAME`, has its
// inputs in lines `#< TIME INPUT VALUE`, its source, and its trace in lines `#> TEXT`.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/languages/urscript/trace_host.h"

namespace takt::languages::urscript::test {
namespace {

struct Example {
  std::string name, file, source;
  std::vector<TraceHost::Change> changes;
  std::vector<std::string> trace;
  bool with_times = false;
};

std::vector<Example> read_examples(const std::filesystem::path& file) {
  std::vector<Example> all;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#@ ")) {
      all.push_back({});
      all.back().name = line.substr(3);
      all.back().file = file.filename().string();
      continue;
    }
    if (all.empty()) continue;
    Example& one = all.back();
    if (line.starts_with("#< ")) {
      TraceHost::Change change;
      std::istringstream(line.substr(3)) >> change.at >> change.input >> change.value;
      one.changes.push_back(change);
    } else if (line == "#times") {
      one.with_times = true;
    } else if (line.starts_with("#> ")) {
      one.trace.push_back(line.substr(3));
    } else {
      one.source += line + "\n";
    }
  }
  return all;
}

std::vector<Example> all_examples() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator("tests/languages/urscript/corpus"))
    files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<Example> all;
  for (const auto& file : files) std::ranges::move(read_examples(file), std::back_inserter(all));
  return all;
}

/// What a program does, or why it cannot: "refused: CODE LINE:COLUMN", "failed: LINE:COLUMN".
std::vector<std::string> trace_of(const Example& one) {
  const std::set<std::string> calls{"close_gripper"};
  const auto program = compile_for_arm({"main.script", one.source}, calls, {"part"});
  std::vector<std::string> trace;
  if (!program) {
    for (const Diagnostic& each : program.error().list())
      trace.push_back(fmt::format("refused: {} {}:{}", name_of(each.code), each.line, each.column));
    return trace;
  }
  TraceHost host(one.changes);
  host.with_times = one.with_times;
  Session session(*program, host, calls, {{"part", Value(Pose{0.5, 0.2, 0.1, 0.0, 0.0, 0.0})}});
  const auto progress = host.run(session);
  trace = host.trace();
  if (progress == Session::Progress::kRunning) trace.emplace_back("runs on");
  if (session.halted()) trace.emplace_back("halted");
  if (progress == Session::Progress::kFailed)
    trace.push_back(fmt::format("failed: {}:{}", session.error().line, session.error().column));
  return trace;
}

TEST(UrscriptCorpus, EachProgramHasItsTrace) {
  const auto examples = all_examples();
  EXPECT_GE(examples.size(), 50u);
  for (const Example& one : examples) {
    std::string wanted, found;
    for (const std::string& line : one.trace) wanted += "#> " + line + "\n";
    for (const std::string& line : trace_of(one)) found += "#> " + line + "\n";
    EXPECT_EQ(found, wanted) << one.file << ": " << one.name;
  }
}

TEST(UrscriptCorpus, TheSameProgramDoesTheSameAgain) {
  for (const Example& one : all_examples()) EXPECT_EQ(trace_of(one), trace_of(one)) << one.name;
}

TEST(UrscriptCorpus, PrintedAndReadAgainItIsTheSame) {
  for (const Example& one : all_examples()) {
    Script script, again;
    ScriptErrors errors;
    if (!parse(one.source, script, errors)) continue;
    const std::string text = print(script);
    EXPECT_TRUE(parse(text, again, errors)) << one.name << "\n" << text;
    EXPECT_EQ(print(again), text) << one.name;
  }
}

}  // namespace
}  // namespace takt::languages::urscript::test
