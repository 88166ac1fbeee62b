// The scenarios with grippers and with two arms, on each kind of arm behind its driver, with the controllers emulated
// in the process: what is expected of the simulation is met, and the arms go the same paths.
#include <algorithm>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "hw/drivers.h"
#include "tests/cell/described.h"

namespace takt::cell::operations_run_test {
namespace {

/// A scenario with other arms than its file has, and their drivers.
struct Operation {
  std::string name, file, model;
  std::vector<std::string> arms, backends;
};
void PrintTo(const Operation& operation, std::ostream* out) { *out << operation.name; }

struct OperationRun {
  RunReport report;
  std::map<std::string, std::vector<device::JointVector>> q;  // measured, by arm, each cycle
};

OperationRun run(const Operation& operation, const std::vector<std::string>& backends) {
  hw::add_own_drivers();
  std::vector<Override> overrides;
  for (const std::string& arm : operation.arms)
    overrides.push_back({"/devices/" + arm + "/model", '"' + operation.model + '"'});
  Diagnostics diagnostics;
  auto description = read_description(operation.file, overrides, {}, diagnostics);
  OperationRun out;
  EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.to_string();
  if (!description) return out;
  for (const std::string& backend : backends) EXPECT_TRUE(cell::bind(description->site, backend).empty());
  auto session = Session::create(std::move(*description), test::models());
  EXPECT_TRUE(session) << session.error().to_string();
  if (!session) return out;
  RunOptions options;
  options.repeat = false;
  options.after_cycle = [&](BuiltCell& built) {
    for (const std::string& arm : operation.arms) {
      const auto& sample = built.cell.arms.at(arm).device->sample();
      if (sample.sequence > 0) out.q[arm].push_back(sample.q);
    }
    return true;
  };
  out.report = (*session)->run(options);
  return out;
}

/// From a point to a piece of a path, rad.
double to_piece(const device::JointVector& q, const device::JointVector& from, const device::JointVector& to) {
  const device::JointVector way = to - from;
  const double length = way.squaredNorm();
  const double share = length > 0.0 ? std::clamp((q - from).dot(way) / length, 0.0, 1.0) : 0.0;
  return (q - from - share * way).cwiseAbs().maxCoeff();
}

/// How far the points of one path, of each tenth cycle, are from another path, rad. Samples of some arms are 8 ms
/// apart.
double farthest(const std::vector<device::JointVector>& a, const std::vector<device::JointVector>& b) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.size(); k += 10) {
    double nearest = 10.0;
    for (std::size_t i = 0; i + 1 < b.size(); ++i) nearest = std::min(nearest, to_piece(a[k], b[i], b[i + 1]));
    most = std::max(most, nearest);
  }
  return most;
}

std::string not_met(const RunReport& report) {
  std::string text = report.diagnostics.to_string();
  for (const ExpectationResult& one : report.expectations)
    if (!one.passed) text += one.name + ": " + one.measured + "\n";
  return text;
}

class OperationsRun : public testing::TestWithParam<Operation> {};

TEST_P(OperationsRun, MeetsTheExpectationsOfTheSimulationOnTheSamePaths) {
  const Operation& operation = GetParam();
  const OperationRun direct = run(operation, {}), driven = run(operation, operation.backends);
  ASSERT_EQ(direct.report.verdict, Verdict::kPassed) << not_met(direct.report);
  ASSERT_EQ(driven.report.verdict, Verdict::kPassed) << not_met(driven.report);
  for (const std::string& arm : operation.arms) {
    EXPECT_EQ(driven.report.site.realities.at(arm), device::BackendMode::kEmulated);
    EXPECT_LE(farthest(direct.q.at(arm), driven.q.at(arm)), 1e-3) << arm;
    EXPECT_LE(farthest(driven.q.at(arm), direct.q.at(arm)), 1e-3) << arm;
  }
}

std::string name_of_operation(const testing::TestParamInfo<Operation>& tested) { return tested.param.name; }

const std::string kPick = "scenarios/pick.json", kCarry = "scenarios/carry.json";

INSTANTIATE_TEST_SUITE_P(
    All, OperationsRun,
    testing::Values(Operation{"PickLwr", kPick, "lwr4plus", {"arm"}, {"arm=fri"}},
                    Operation{"PickUr5", kPick, "ur5", {"arm"}, {"arm=rtde", "gripper=wsg", "io=terminals:arm"}},
                    Operation{"PickTx90", kPick, "tx90", {"arm"}, {"arm=cia402"}},
                    Operation{"CarryLwr", kCarry, "lwr4plus", {"left", "right"}, {"left=fri", "right=fri"}},
                    Operation{"CarryUr5", kCarry, "ur5", {"left", "right"}, {"left=rtde", "right=rtde"}},
                    Operation{"CarryTx90", kCarry, "tx90", {"left", "right"}, {"left=cia402", "right=cia402"}}),
    name_of_operation);

}  // namespace
}  // namespace takt::cell::operations_run_test
