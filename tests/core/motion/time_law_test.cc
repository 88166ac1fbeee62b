#include "core/motion/time_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/random.h"
#include "tests/core/motion/shortest_time.h"
#include "tests/support/reports.h"

namespace takt::motion {
namespace {

using takt::test::Reports;

RateLimits random_limits(Random& random) {
  return {.velocity = std::exp(random.uniform(-3, 4)),
          .acceleration = std::exp(random.uniform(-3, 6)),
          .jerk = std::exp(random.uniform(-2, 9))};
}

TEST(TimeLaw, RestToRestIsAsFastAsAnIndependentGenerator) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const RateLimits limits = random_limits(random);
    const double expected = test::shortest_time({limits.velocity, limits.acceleration, limits.jerk}, 1.0);
    EXPECT_NEAR(TimeLaw::rest_to_rest(limits).duration(), expected, 1e-8 * expected) << "case " << i;
  }
}

TEST(TimeLaw, RestToRestKeepsItsLimitsAndMeetsItsEnds) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const RateLimits limits = random_limits(random);
    const TimeLaw law = TimeLaw::rest_to_rest(limits);
    double last = 0.0;
    for (int n = 0; n <= 500; ++n) {
      const LawPoint at = law.at(law.duration() * n / 500);
      EXPECT_GE(at.s, last) << "the law runs back, case " << i;
      EXPECT_LE(at.ds, limits.velocity * (1 + 1e-9));
      EXPECT_LE(std::abs(at.dds), limits.acceleration * (1 + 1e-9));
      EXPECT_LE(std::abs(at.ddds), limits.jerk * (1 + 1e-9));
      last = at.s;
    }
    const LawPoint before_end = law.at(law.duration() * (1 - 1e-12));
    EXPECT_NEAR(before_end.s, 1.0, 1e-10);
    EXPECT_EQ(law.at(law.duration()).s, 1.0);
    EXPECT_EQ(law.at(law.duration()).ds, 0.0);
    EXPECT_EQ(law.at(0.0).s, 0.0);
    EXPECT_EQ(law.at(0.0).ds, 0.0);
  }
}

TEST(TimeLaw, DerivativesBelongTogether) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const TimeLaw law = TimeLaw::rest_to_rest(random_limits(random));
    const double h = law.duration() * 1e-5;
    for (int n = 0; n < 50; ++n) {
      const double tau = law.duration() * random.uniform(0.001, 0.999);
      const LawPoint left = law.at(tau - h);
      const LawPoint right = law.at(tau + h);
      const LawPoint at = law.at(tau);
      // Central differences are off by at most jerk h^2 / 3 and jerk h.
      double jerk = 0.0;
      for (const auto& segment : law.segments()) jerk = std::max(jerk, std::abs(segment.jerk));
      EXPECT_NEAR((right.s - left.s) / (2 * h), at.ds, jerk * h * h / 3 + 1e-15 / h);
      EXPECT_NEAR((right.ds - left.ds) / (2 * h), at.dds, jerk * h + 1e-15 / h * at.ds);
    }
  }
}

TEST(TimeLaw, StandsBeforeItsStartAndAfterItsEnd) {
  const TimeLaw law = TimeLaw::rest_to_rest({1.0, 2.0, 8.0});
  EXPECT_EQ(law.at(-1.0).s, 0.0);
  EXPECT_EQ(law.at(-1.0).ds, 0.0);
  EXPECT_EQ(law.at(1e9).s, 1.0);
  EXPECT_EQ(law.at(1e9).dds, 0.0);
  EXPECT_EQ(law.at(std::numeric_limits<double>::quiet_NaN()).s, 1.0);
  EXPECT_EQ(TimeLaw().at(0.0).s, 1.0) << "a law without length is at its end";
  EXPECT_EQ(TimeLaw().duration(), 0.0);
}

TEST(TimeLaw, StretchedIsTheSameShapeSlower) {
  const TimeLaw law = TimeLaw::rest_to_rest({1.0, 2.0, 8.0});
  const TimeLaw slow = law.stretched(3.0);
  EXPECT_DOUBLE_EQ(slow.duration(), 3.0 * law.duration());
  for (double part = 0.05; part < 1.0; part += 0.1) {
    const LawPoint a = law.at(part * law.duration());
    const LawPoint b = slow.at(part * slow.duration());
    EXPECT_NEAR(b.s, a.s, 1e-12);
    EXPECT_NEAR(b.ds, a.ds / 3, 1e-12);
    EXPECT_NEAR(b.dds, a.dds / 9, 1e-12);
  }
}

TEST(TimeLaw, TheRestOfALawIsTheLawOverTheRestOfThePath) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    const TimeLaw law = TimeLaw::rest_to_rest(random_limits(random));
    const double from = random.uniform(0.0, 0.95) * law.duration();
    const LawPoint here = law.at(from);
    const TimeLaw rest = law.rest_from(from);
    EXPECT_TRUE(rest.begins_in_motion());
    EXPECT_NEAR(rest.duration(), law.duration() - from, 1e-12 * law.duration());
    for (int n = 0; n <= 50; ++n) {
      const double tau = (law.duration() - from) * n / 50;
      const LawPoint whole = law.at(from + tau), part = rest.at(tau);
      const double left = 1.0 - here.s;
      EXPECT_NEAR(here.s + left * part.s, whole.s, 1e-11);
      EXPECT_NEAR(left * part.ds, whole.ds, 1e-9 * (1.0 + std::abs(here.ds))) << "case " << i;
    }
    const auto text = parse_json(to_json(rest).dump());
    const auto read = time_law_from_json(*text);
    ASSERT_TRUE(read) << read.error().to_string();
    EXPECT_EQ(read->at(0.3 * rest.duration()).s, rest.at(0.3 * rest.duration()).s);
    EXPECT_EQ(read->begin().ds, rest.begin().ds);
  }
  EXPECT_EQ(TimeLaw::rest_to_rest({1, 1, 1}).rest_from(1e9).duration(), 0.0);
}

TEST(TimeLaw, SurvivesJsonTextBitForBit) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const TimeLaw law = TimeLaw::rest_to_rest(random_limits(random));
    const auto text = parse_json(to_json(law).dump());
    ASSERT_TRUE(text);
    const auto read = time_law_from_json(*text);
    ASSERT_TRUE(read) << read.error().to_string();
    EXPECT_EQ(read->duration(), law.duration());
    for (int n = 0; n < 20; ++n) {
      const double tau = random.uniform(0.0, law.duration());
      EXPECT_EQ(read->at(tau).s, law.at(tau).s);
      EXPECT_EQ(read->at(tau).ds, law.at(tau).ds);
      EXPECT_EQ(read->at(tau).dds, law.at(tau).dds);
    }
  }
}

Diagnostics law_refusal(const char* text) {
  const auto law = time_law_from_json(nlohmann::ordered_json::parse(text), "/law");
  return law ? Diagnostics() : law.error();
}

TEST(TimeLaw, RefusesWhatIsNoLawAndSaysWhy) {
  EXPECT_THAT(law_refusal("3"), Reports(Code::kWrongType, "/law"));
  EXPECT_THAT(law_refusal("[[1, 2], [1]]"), Reports(Code::kWrongType, "/law/1"));
  EXPECT_THAT(law_refusal("[[-1, 2]]"), Reports(Code::kOutOfRange, "/law/0", {"-1"}));
  EXPECT_THAT(law_refusal("[[1, 6]]"), Reports(Code::kOutOfRange, "/law", {"3", "1"})) << "at s = 1, but in motion";
  EXPECT_THAT(law_refusal("[[1, 1], [2, -1], [1, 1]]"), Reports(Code::kOutOfRange, "/law", {"2"}));
  EXPECT_EQ(law_refusal("[[1, 0.5], [2, -0.5], [1, 0.5]]").to_string(), "");
  EXPECT_EQ(law_refusal("[]").to_string(), "");
  EXPECT_EQ(law_refusal(R"({"begin": [3, -6], "pieces": [[1, 6]]})").to_string(), "");
  EXPECT_THAT(law_refusal(R"({"begin": [1, 0], "pieces": [[1, 0]]})"), Reports(Code::kOutOfRange, "/law", {"1"}));
  EXPECT_THAT(law_refusal(R"({"begin": [-1, 0], "pieces": [[1, 0]]})"),
              Reports(Code::kOutOfRange, "/law/begin", {"-1"}));
  EXPECT_THAT(law_refusal(R"({"begin": [1], "peices": []})"), Reports(Code::kUnknownKey, "/law/peices", {"peices"}));
  EXPECT_THAT(law_refusal(R"({"begin": [1, 0], "pieces": [[1]]})"), Reports(Code::kWrongType, "/law/pieces/0"));
}

TEST(TimeLaw, RefusesNumbersThatAreNotFinite) {
  EXPECT_FALSE(TimeLaw::create({{std::numeric_limits<double>::quiet_NaN(), 1.0}}));
  EXPECT_FALSE(TimeLaw::create({{1.0, std::numeric_limits<double>::infinity()}}));
}

}  // namespace
}  // namespace takt::motion
