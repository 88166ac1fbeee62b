#include "core/base/json_lines.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"

namespace takt {
namespace {

using Json = nlohmann::ordered_json;

TEST(JsonLines, WhatFitsIntoALineStandsInOne) {
  EXPECT_EQ(in_lines(Json{{"a", 1}, {"b", {1.5, "x", nullptr}}}), R"({"a": 1, "b": [1.5, "x", null]})");
  EXPECT_EQ(in_lines(Json::object()), "{}");
  EXPECT_EQ(in_lines(Json::array()), "[]");
  EXPECT_EQ(in_lines(Json("a \"word\"")), R"("a \"word\"")");
}

TEST(JsonLines, ALongObjectHasALineForEachMember) {
  const std::string name(60, 'n');
  EXPECT_EQ(in_lines(Json{{"first", name}, {"second", {{"name", name}}}}),
            "{\n  \"first\": \"" + name + "\",\n  \"second\": {\"name\": \"" + name + "\"}\n}");
}

TEST(JsonLines, NumbersFillLines) {
  Json numbers = Json::array();
  for (int i = 0; i < 200; ++i) numbers.push_back(i);
  const std::string text = in_lines(Json{{"numbers", numbers}});
  EXPECT_LT(std::ranges::count(text, '\n'), 16);
  EXPECT_EQ(Json::parse(text).at("numbers"), numbers);
}

Json random_json(Random& random, int depth) {
  const int kind = static_cast<int>(random.uniform(0, depth > 0 ? 6 : 4));
  if (kind < 2) return random.uniform(-1e3, 1e3);
  if (kind < 3) return std::string(static_cast<std::size_t>(random.uniform(0, 80)), 'x');
  if (kind < 4) return nullptr;
  Json json = kind < 5 ? Json::object() : Json::array();
  const int members = static_cast<int>(random.uniform(0, 12));
  for (int i = 0; i < members; ++i) {
    Json value = random_json(random, depth - 1);
    if (json.is_object())
      json["key " + std::to_string(i)] = std::move(value);
    else
      json.push_back(std::move(value));
  }
  return json;
}

TEST(JsonLines, ReadsBackAsItWas) {
  Random random(5);
  for (int i = 0; i < 500; ++i) {
    const Json json = random_json(random, 5);
    EXPECT_EQ(Json::parse(in_lines(json)), json);
  }
}

}  // namespace
}  // namespace takt
