// Where in a file an element stands: what a person is led to.
#include "core/base/text_location.h"

#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "tests/support/scratch_folder.h"

namespace takt {
namespace {

constexpr const char* kText = R"({
  "name": "a", "list": [1, {"x": "}\"{"},
    [true, null]],
  "deep/er": {"a~b": -1.5e3}
})";

TextLocation at(std::string_view text, const std::string& pointer) {
  return locate_pointers(text, {pointer}).at(pointer);
}

TEST(TextLocationTest, AMemberIsAtItsKeyAndAnElementAtItsFirstCharacter) {
  EXPECT_EQ(at(kText, "/name"), (TextLocation{2, 3}));
  EXPECT_EQ(at(kText, "/list"), (TextLocation{2, 16}));
  EXPECT_EQ(at(kText, "/list/0"), (TextLocation{2, 25}));
  EXPECT_EQ(at(kText, "/list/1"), (TextLocation{2, 28}));
  EXPECT_EQ(at(kText, "/list/1/x"), (TextLocation{2, 29}));
  EXPECT_EQ(at(kText, "/list/2"), (TextLocation{3, 5}));
  EXPECT_EQ(at(kText, "/list/2/1"), (TextLocation{3, 12}));
}

TEST(TextLocationTest, EscapedPointersFindTheirKeys) {
  EXPECT_EQ(at(kText, "/deep~1er"), (TextLocation{4, 3}));
  EXPECT_EQ(at(kText, "/deep~1er/a~0b"), (TextLocation{4, 15}));
}

TEST(TextLocationTest, WhatIsNotThereIsAtTheElementAroundIt) {
  EXPECT_EQ(at(kText, "/list/1/missing"), (TextLocation{2, 28}));
  EXPECT_EQ(at(kText, "/list/7/deeper/still"), (TextLocation{2, 16}));
  EXPECT_EQ(at(kText, "/nothing"), (TextLocation{1, 1}));
}

TEST(TextLocationTest, BrokenTextsEndTheWalkAndNothingElse) {
  for (const char* text : {"", "{", "\"", "\"\\", "[[[", "]]}}", ",,:", "{\"a\"", "{\"a\":1}}]", "\n\n{\"a\n\": 1}"})
    EXPECT_EQ(at(text, "/b"), (TextLocation{1, 1})) << text;
}

TEST(TextLocationTest, DiagnosticsOfAFileGetLineAndColumn) {
  const test::ScratchFolder folder;
  const auto file = (folder.path() / "cell.json").string();
  std::ofstream(file) << kText;
  Diagnostics diagnostics;
  diagnostics.error(Code::kOutOfRange, "/list/0", "1 is out of range", "2 to 3");
  diagnostics.error(Code::kUsage, "--size", "an option");
  diagnostics.note("", "about the whole");
  diagnostics.set_file(file);
  locate(diagnostics);
  EXPECT_EQ(to_string(diagnostics.list()[0]), file + ":2:25:/list/0: error: 1 is out of range (2 to 3) [out-of-range]");
  EXPECT_EQ(diagnostics.list()[1].line, 0) << "an option is not an element of a file";
  EXPECT_EQ(diagnostics.list()[2].line, 0);
}

TEST(TextLocationTest, ASyntaxErrorIsWhereTheReaderStopped) {
  const test::ScratchFolder folder;
  const auto file = folder / "broken.json";
  std::ofstream(file) << "{\"program\":\n  {\"do\": \"wait\", }\n}\n";
  const auto read = read_json(file);
  ASSERT_FALSE(read);
  Diagnostics diagnostics = read.error();
  locate(diagnostics);
  EXPECT_EQ(diagnostics.list()[0].code, Code::kSyntax);
  EXPECT_EQ(diagnostics.list()[0].line, 2);
  EXPECT_EQ(diagnostics.list()[0].column, 18) << "the brace";
}

TEST(TextLocationTest, AFileThatIsGoneLeavesDiagnosticsAsTheyAre) {
  Diagnostics diagnostics;
  diagnostics.error(Code::kMissing, "/name", "key 'name' is missing");
  diagnostics.set_file("no/such/file.json");
  EXPECT_EQ(to_located_text(diagnostics), "no/such/file.json:/name: error: key 'name' is missing [missing]\n");
}

}  // namespace
}  // namespace takt
