#include "serve/panel_files.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/serve/served.h"
#include "tests/support/scratch_folder.h"

namespace takt::serve::test {
namespace {

/// A folder with a page, and with a file beside it that is none of the page.
class PanelFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"index.html", "panel.js", "panel.css", "icon.svg", "licences.txt"})
      write(name, std::string("content of ") + name);
    write("panel.js.gz", "packed");
    write("secret.txt", "not for anybody");
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder / name) << text; }

  [[nodiscard]] static HttpRequest ask(const std::string& method, const std::string& target) {
    HttpRequest request;
    request.method = method;
    request.target = target;
    return request;
  }
  [[nodiscard]] static HttpRequest get(const std::string& target) { return ask("GET", target); }

  const takt::test::ScratchFolder scratch{"panel"};
  const std::filesystem::path& folder = scratch.path();
};

TEST_F(PanelFilesTest, HandsOutItsListAndNothingElse) {
  const PanelFiles page = PanelFiles::read(folder);
  ASSERT_TRUE(page.complete());
  EXPECT_EQ(page.answer(get("/"))->body, "content of index.html");
  EXPECT_EQ(page.answer(get("/?a=b"))->body, "content of index.html");
  EXPECT_EQ(page.answer(get("/panel.css"))->content_type, "text/css; charset=utf-8");
  for (const char* other : {"/secret.txt", "/index.html", "/panel.js.gz", "/../panel.js", "/%2e%2e/panel.js",
                            "//panel.js", "/panel.js/", "/PANEL.JS", "panel.js", "", "/v1/state"})
    EXPECT_FALSE(page.answer(get(other)).has_value()) << other;
  EXPECT_FALSE(page.answer(ask("POST", "/")).has_value());
}

TEST_F(PanelFilesTest, AnUpdateIsSeenAtOnceAndACopyThatHoldsIsNotSentAgain) {
  const PanelFiles page = PanelFiles::read(folder);
  const HttpResponse first = *page.answer(get("/panel.js"));
  EXPECT_EQ(first.headers.at("Cache-Control"), "no-cache");
  HttpRequest again = get("/panel.js");
  again.headers["if-none-match"] = first.headers.at("ETag");
  EXPECT_EQ(page.answer(again)->status, 304);
  EXPECT_TRUE(page.answer(again)->body.empty());
  write("panel.js", "a newer one");
  const PanelFiles newer = PanelFiles::read(folder);
  EXPECT_EQ(newer.answer(again)->status, 200);
  EXPECT_EQ(newer.answer(again)->body, "a newer one");
}

TEST_F(PanelFilesTest, IsPackedForWhoCanUnpack) {
  const PanelFiles page = PanelFiles::read(folder);
  HttpRequest request = get("/panel.js");
  EXPECT_EQ(page.answer(request)->body, "content of panel.js");
  request.headers["accept-encoding"] = "br, gzip";
  EXPECT_EQ(page.answer(request)->body, "packed");
  EXPECT_EQ(page.answer(request)->headers.at("Content-Encoding"), "gzip");
  request.target = "/panel.css";  // there is no packed one
  EXPECT_EQ(page.answer(request)->body, "content of panel.css");
}

TEST_F(PanelFilesTest, HalfAPageIsNone) {
  std::filesystem::remove(folder / "panel.css");
  const PanelFiles page = PanelFiles::read(folder);
  EXPECT_FALSE(page.complete());
  EXPECT_EQ(page.answer(get("/"))->status, 404);
  EXPECT_FALSE(page.answer(get("/panel.js")).has_value());
}

TEST_F(PanelFilesTest, ThePageNeedsNoTokenAndAPageOfAnotherHostGetsNothing) {
  const Served served(true, {.tokens = {{.role = Role::kObserver, .name = "o", .secret = "0123456789abcdef"}},
                             .page = PanelFiles::read(folder)});
  Client client = served.client();
  const Answer page = client.get("/");
  EXPECT_EQ(page.status, 200);
  const std::string& policy = page.headers.at("Content-Security-Policy");
  for (const char* part : {"default-src 'none'", "script-src 'self'", "frame-ancestors 'none'"})
    EXPECT_NE(policy.find(part), std::string::npos) << policy;
  EXPECT_EQ(client.get("/v1/state").status, 401);
  client.headers["Host"] = "elsewhere:80";
  EXPECT_EQ(client.get("/").status, 421);
}

}  // namespace
}  // namespace takt::serve::test
