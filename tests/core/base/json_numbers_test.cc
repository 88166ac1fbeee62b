#include "core/base/json_numbers.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace takt {
namespace {

using Json = nlohmann::ordered_json;

TEST(WithoutNoise, WhatArithmeticLeftInTheLastDigitsIsGone) {
  const Json noisy = {{"a", 1.7000000000000002}, {"b", {0.1 + 0.2, 12.100000000000001, {{"c", 4.199999999999999}}}}};
  EXPECT_EQ(without_noise(noisy).dump(), R"({"a":1.7,"b":[0.3,12.1,{"c":4.2}]})");
}

TEST(WithoutNoise, WhatIsNoNoiseKeepsEveryBit) {
  const Json exact = {std::numbers::pi, 1.0 / 3.0, 1e-300, -0.0, 5, "1.7000000000000002", true, nullptr, 1e22};
  EXPECT_EQ(without_noise(exact).dump(), exact.dump());
  EXPECT_TRUE(std::isnan(without_noise(std::numeric_limits<double>::quiet_NaN()).get<double>()));
}

TEST(WithoutNoise, NumbersOfFewDigitsComeBackFromAnySum) {
  std::mt19937 random(7);
  for (int i = 0; i < 2000; ++i) {
    const double wanted = static_cast<double>(1000 + random() % 1000000) / 1000;
    const double part = wanted * 0.1;
    EXPECT_EQ(without_noise(Json((wanted - part) + part)).dump(), Json(wanted).dump());
  }
}

}  // namespace
}  // namespace takt
