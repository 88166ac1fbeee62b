#pragma once

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/activity/runtime.h"
#include "tests/core/program/tree/program_runs.h"
#include "tests/support/fake_cell.h"

namespace takt::test {

/// Parses programs against a fake cell and runs them on it.
class ActivityTest : public ProgramRuns {
 protected:
  Result<program::Program> parse(const std::string& text) const {
    return program::Program::parse(Json::parse(text), "/program", fake.cell);
  }
  /// Only its form is looked at.
  program::Program good(const std::string& text) const {
    auto program = parse(text);
    if (!program) ADD_FAILURE() << program.error().to_string();
    return program ? std::move(*program) : program::Program();
  }
  /// Pointers of what is wrong with the form of a program.
  std::vector<std::string> refused(const std::string& text) const {
    const auto program = parse(text);
    return program ? std::vector<std::string>() : pointers(program.error());
  }

  static std::string sequence(const std::string& steps) { return R"({"do": "sequence", "steps": [)" + steps + "]}"; }
  Diagnostics rehearsed(const std::string& text) {
    return good(text).rehearse(fake.cell, &fake.core.environment()).diagnostics;
  }
  /// Ends whatever runs by its stop reaction.
  void abort_all() {
    for (rcc::NetId net = 1; net < 1000; ++net) {
      if (fake.core.knows(net) && fake.core.state(net) == rcc::NetState::kRunning) (void)fake.core.abort(net);
    }
  }

  /// Cycles in which the arm stood, between its first and its last motion.
  int standing_cycles() const {
    const auto& sent = fake.backend->sent;
    std::size_t first = 0;
    std::size_t last = sent.size() - 1;
    while (first < last && sent[first].dq.isZero(0.0)) ++first;
    while (last > first && sent[last].dq.isZero(0.0)) --last;
    // Its very first and last cycles are slow too.
    constexpr std::size_t kRamp = 20;
    int count = 0;
    for (std::size_t i = first + kRamp; i + kRamp <= last; ++i) count += sent[i].dq.cwiseAbs().maxCoeff() < 1e-4;
    return count;
  }

  using ProgramRuns::run;
  operations::Progress run(const std::string& text) { return run(good(text)); }

  /// Rows L6, P2: wherever it is cancelled, the arm comes to rest in time, inside its limits, without a diagnostic, and
  /// is free again: it goes home.
  void cancel_at_every_tenth_cycle(const program::Program& program) {
    const program::Program home = good(R"({"do": "ptp", "to": "home"})");
    ASSERT_EQ(run(program), operations::Progress::kDone) << diagnostics.to_string();
    const int whole = cycles;
    ASSERT_EQ(run(home), operations::Progress::kDone);
    for (int at = 0; at < whole; at += 10) {
      SCOPED_TRACE(at);
      fake.backend->sent.clear();
      ASSERT_EQ(run(program, cancelling(at)), operations::Progress::kDone);
      EXPECT_LT(cycles, at + 800);
      EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
      EXPECT_TRUE(fake.core_arm().at_rest());
      ASSERT_EQ(run(home), operations::Progress::kDone) << "the arm is free again";
      ASSERT_LE(fake.worst_limit_share(), 1.0);
    }
  }

  FakeCell fake{[this] {
    const Diagnostics wrong = activity::declare_channels(fake.core, fake.cell);
    EXPECT_FALSE(wrong.has_errors()) << wrong.to_string();
  }};

 private:
  [[nodiscard]] expression::Cell& programs_cell() override { return fake.cell; }
  [[nodiscard]] rcc::ControlCore& programs_core() override { return fake.core; }
  void one_cycle() override { fake.step(); }
};

}  // namespace takt::test
