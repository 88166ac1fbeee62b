// The codes of diagnostics: stable names, one meaning each, and a page that lists them all.
#include "core/base/diagnostics.h"

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace takt {
namespace {

std::string page() {
  std::stringstream text;
  text << std::ifstream("docs/diagnostics.md").rdbuf();
  return text.str();
}

TEST(DiagnosticsTest, EveryCodeHasANameOfItsOwnAndLeadsBackToIt) {
  std::set<std::string_view> names;
  for (const Code code : all_codes()) {
    EXPECT_TRUE(names.insert(name_of(code)).second) << name_of(code);
    EXPECT_TRUE(std::regex_match(std::string(name_of(code)), std::regex("[a-z]+(-[a-z]+)*"))) << name_of(code);
    EXPECT_EQ(code_named(name_of(code)), code);
  }
  EXPECT_EQ(code_named("no-such-code"), std::nullopt);
}

TEST(DiagnosticsTest, ThePageListsEveryCodeWithItsMeaning) {
  const std::string text = page();
  for (const Code code : all_codes())
    EXPECT_NE(text.find(fmt::format("| `{}` | {} |", name_of(code), meaning_of(code))), std::string::npos)
        << fmt::format("docs/diagnostics.md lacks the row: | `{}` | {} |", name_of(code), meaning_of(code));
}

TEST(DiagnosticsTest, AppendingKeepsTheCode) {
  Diagnostics inner, outer;
  inner.error(Code::kUnknownName, "/arm", "unknown arm 'x'");
  outer.append(inner, "/program/steps/3", "a.json");
  EXPECT_EQ(outer.to_string(), "a.json:/program/steps/3/arm: error: unknown arm 'x' [unknown-name]\n");
}

}  // namespace
}  // namespace takt
