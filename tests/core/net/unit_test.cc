#include "core/net/unit.h"

#include <gtest/gtest.h>

#include "core/net/frame_check.h"

namespace takt::net {
namespace {

std::string read(std::string_view text) {
  const auto terms = parse_unit(text);
  if (!terms) return "malformed";
  std::string all;
  for (const UnitTerm& term : *terms) {
    all += (all.empty() ? "" : ",") + to_string(term.dimension);
    for (const auto& [name, power] : term.variables) {
      all += fmt::format(" {}^{}", name, power.numerator);
      if (power.denominator != 1) all += fmt::format("/{}", power.denominator);
    }
  }
  return all;
}

TEST(Unit, RowU1Texts) {
  EXPECT_EQ(read("m/s^2"), "m/s^2");
  EXPECT_EQ(read("kg*m/s^2"), "N");
  EXPECT_EQ(read("N*m"), "Nm");
  EXPECT_EQ(read("1/s"), "Hz");
  EXPECT_EQ(read("rad/s"), "rad/s");
  EXPECT_EQ(read("1"), "1");
  EXPECT_EQ(read("u/s"), "Hz u^1");
  EXPECT_EQ(read("u*v"), "1 u^1 v^1");
  EXPECT_EQ(read("u/v/u"), "1 v^-1");
  EXPECT_EQ(read("u^1/2*m"), "m u^1/2");
  EXPECT_EQ(read("u^1/2/s"), "Hz u^1/2");
  EXPECT_EQ(read("m/s,rad/s"), "m/s,rad/s");
  EXPECT_EQ(read(""), "");
}

TEST(Unit, MalformedTexts) {
  for (const char* text : {"mm", "m//s", "m*", "*", "m^", "m^x", "m^1/0", "deg", "m,s,kg", "m s", "U"}) {
    EXPECT_EQ(read(text), "malformed") << text;
  }
}

TEST(Unit, RadiansAreABaseOfTheirOwn) {
  EXPECT_NE(parse_unit("rad")->front().dimension, parse_unit("1")->front().dimension);
  EXPECT_NE(parse_unit("Nm")->front().dimension, parse_unit("Nm/rad")->front().dimension);
}

TEST(Unit, FractionsStayExactOrSayThatTheyDoNot) {
  const Rational half{1, 2}, third{1, 3};
  EXPECT_EQ(half + third, (Rational{5, 6}));
  EXPECT_EQ(half - half, (Rational{0, 1}));
  EXPECT_EQ(half / third, (Rational{3, 2}));
  Rational big{1'000'000'000, 1};
  EXPECT_TRUE(big.valid());
  big = big * Rational{2, 1};
  EXPECT_FALSE(big.valid());
  EXPECT_FALSE((big - big).valid());
  EXPECT_FALSE(big.zero());
}

TEST(FrameNames, RowU2Texts) {
  PrimitiveInfo info;
  info.parameters.push_back({"base", "String", {}, "\"\""});
  info.parameters.push_back({"gain", "Real", {}, "1"});
  const auto names = parse_frame_names("A>@base>flange", info);
  ASSERT_TRUE(names.has_value());
  ASSERT_EQ(names->size(), 3u);
  EXPECT_EQ((*names)[0].kind, FrameName::Kind::kVariable);
  EXPECT_EQ((*names)[1].kind, FrameName::Kind::kParameter);
  EXPECT_EQ((*names)[1].text, "base");
  EXPECT_EQ((*names)[2].kind, FrameName::Kind::kLiteral);
  EXPECT_TRUE(parse_frame_names("", info)->empty());
  for (const char* text : {"A>", ">B", "@nothing", "@gain>A", "A>>B"})
    EXPECT_FALSE(parse_frame_names(text, info)) << text;
}

}  // namespace
}  // namespace takt::net
