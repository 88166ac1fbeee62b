#include "tools/robustness/robustness.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

Variation ended(std::uint64_t seed, int status, double force) {
  Variation variation{.seed = seed, .command = {"run", "a cell.json", "--seed", std::to_string(seed)}, .end = {}};
  variation.end.status = status;
  variation.end.output = R"({"result": "passed", "sim_time": 12.5})";
  variation.report = RunSummary{.sim_time = 12.5, .wall_time = 2.5};
  variation.report->expectations = {{.name = "gently",
                                     .kind = "peak_force",
                                     .measured = "so much",
                                     .unit = "N",
                                     .passed = status == 0,
                                     .value = force,
                                     .upper = 30}};
  return variation;
}

Robustness three_of_four() {
  Robustness robustness{.file = "a cell.json", .title = "A <cell>", .needed = 3};
  robustness.variations = {ended(1, 0, 10), ended(2, 1, 31), ended(3, 0, 14), ended(4, 0, 12)};
  return robustness;
}

TEST(RobustnessReport, CountsWhatPassedAndSpreadsWhatWasMeasured) {
  const Robustness robustness = three_of_four();
  EXPECT_EQ(robustness.passed(), 3u);
  EXPECT_TRUE(robustness.holds());
  const auto expectations = robustness.expectations();
  ASSERT_EQ(expectations.size(), 1u);
  EXPECT_EQ(expectations[0].passed(), 3u);
  EXPECT_EQ(expectations[0].spread().least, 10);
  EXPECT_EQ(expectations[0].spread().median, 13);
  EXPECT_EQ(expectations[0].spread().greatest, 31);
  EXPECT_EQ(expectations[0].upper, 30);
  EXPECT_EQ(expectations[0].lower, std::nullopt);
}

/// A run that was cut off says nothing about the program.
TEST(RobustnessReport, WhatWasCutOffCountsNeitherAsPassedNorAsFailed) {
  Robustness robustness = three_of_four();
  robustness.variations.push_back(ended(5, 130, 99));
  EXPECT_EQ(robustness.passed(), 3u);
  EXPECT_EQ(robustness.interrupted(), 1u);
  EXPECT_EQ(robustness.expectations().at(0).judged.size(), 4u);
  EXPECT_EQ(robustness.expectations().at(0).spread().greatest, 31);
  EXPECT_EQ(robustness.share_at_least(), three_of_four().share_at_least());
  EXPECT_THAT(robustness.variations[4].message(), Not(HasSubstr("gently")));
  EXPECT_EQ(to_json(robustness)["result"], "interrupted");
}

TEST(RobustnessReport, HoldsOnlyIfEnoughPassAndEveryFailureEndedInOrder) {
  Robustness robustness = three_of_four();
  robustness.needed = 4;
  EXPECT_FALSE(robustness.holds());
  robustness.needed = 3;
  robustness.variations[1].report.reset();
  robustness.variations[1].end.signal = 11;
  EXPECT_FALSE(robustness.holds()) << "a crash is no orderly end";
  EXPECT_THAT(robustness.variations[1].message(), HasSubstr("11"));
}

/// Clopper and Pearson, one-sided, 95 %: of n passes of n the bound is 0.05^(1/n); 19 of 20 give 78.4 %.
TEST(RobustnessReport, SaysWhatShareOfAllVariationsPasses) {
  Robustness robustness;
  EXPECT_EQ(robustness.share_at_least(), 0.0);
  for (int seed = 1; seed <= 20; ++seed) robustness.variations.push_back(ended(seed, 0, 10));
  EXPECT_NEAR(robustness.share_at_least(), std::pow(0.05, 1.0 / 20.0), 1e-9);
  robustness.variations.back().end.status = 1;
  EXPECT_NEAR(robustness.share_at_least(), 0.7839, 1e-4);
}

TEST(RobustnessReport, AFailureSaysWhy) {
  Variation broken = ended(1, 3, 10);
  broken.report->error = "/program/steps/3: no contact";
  EXPECT_EQ(broken.message(), "/program/steps/3: no contact");
  EXPECT_THAT(ended(1, 1, 31).message(), HasSubstr("gently"));
  EXPECT_EQ(ended(1, 0, 10).message(), "");
}

TEST(RobustnessReport, IsOnePageThatNeedsNothingElse) {
  Robustness robustness = three_of_four();
  robustness.variations[1].film = std::string("\x00\x01\x02\xff", 4);
  const std::string page = to_html(robustness);
  EXPECT_THAT(page, HasSubstr("A &lt;cell&gt;"));
  EXPECT_THAT(page, HasSubstr("data:video/mp4;base64,AAEC/w=="));
  EXPECT_THAT(page, HasSubstr("run 'a cell.json' --seed 2"));
  EXPECT_THAT(page, HasSubstr("id=\"seed-2\""));
  EXPECT_THAT(page, Not(HasSubstr("http")));
  EXPECT_THAT(page, Not(HasSubstr("id=\"seed-1\"")));
}

TEST(RobustnessReport, JsonHoldsEveryVariation) {
  const Json json = to_json(three_of_four());
  EXPECT_EQ(json["passed"], 3);
  EXPECT_EQ(json["variations"].size(), 4u);
  EXPECT_EQ(json["variations"][1]["status"], 1);
  EXPECT_EQ(json["expectations"][0]["greatest"], 31);
}

TEST(RobustnessReport, AmountsHaveTheUnitOfTheirSize) {
  EXPECT_EQ(amount_text(0.00125, "m"), "1.25 mm");
  EXPECT_EQ(amount_text(1.5, "m"), "1.5 m");
  EXPECT_EQ(amount_text(12.345, "N"), "12.3 N");
  EXPECT_EQ(amount_text(0.5, ""), "0.5");
}

}  // namespace
}  // namespace takt::tools
