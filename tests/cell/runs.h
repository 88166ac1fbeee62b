#pragma once

#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/cell/described.h"

namespace takt::cell::test {

/// A run and the session behind it: the cell as the run has left it. `session` is null where it was refused.
struct Ran {
  std::unique_ptr<Session> session;
  RunReport report;

  [[nodiscard]] const BuiltCell& built() const { return session->built(); }
  [[nodiscard]] const expression::Cell& cell() const { return built().cell; }
};

/// A description that is refused fails the test.
inline Ran run_kept(Description description, const RunOptions& options = {}) {
  auto session = Session::create(std::move(description), models());
  if (!session) {
    ADD_FAILURE() << session.error().to_string();
    return {};
  }
  Ran done{.session = std::move(*session), .report = {}};
  done.report = done.session->run(options);
  return done;
}

/// As run_kept(), where only the report counts.
inline RunReport run(Description description, const RunOptions& options = {}) {
  return run_kept(std::move(description), options).report;
}

/// Why no session can be made; empty where one can.
inline Diagnostics refusal(Description description) {
  const auto session = Session::create(std::move(description), models());
  return session ? Diagnostics() : session.error();
}

/// The run and each of its expectations.
inline void expect_passed(const RunReport& report) {
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  for (const auto& one : report.expectations) EXPECT_TRUE(one.passed) << one.name << ": " << one.measured;
}

}  // namespace takt::cell::test
