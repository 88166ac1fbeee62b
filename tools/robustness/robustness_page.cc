// The report for people: one page with everything in it, the films of failures too.
#include <algorithm>
#include <array>
#include <cstdint>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/xml_text.h"
#include "record/report_style.h"
#include "tools/robustness/robustness.h"
#include "tools/robustness/strip_plot.h"

namespace takt::tools {
namespace {

constexpr std::string_view kPageStyle = R"css(
.tiles { display: flex; flex-wrap: wrap; gap: 12px; margin-bottom: 16px; }
.tile { flex: 1 1 200px; background: #fff; border: 1px solid var(--line); border-radius: 10px; padding: 12px 18px; }
.tile b { display: block; font-size: 21px; font-variant-numeric: tabular-nums; }
.seeds { display: flex; flex-wrap: wrap; gap: 5px; }
.seed { min-width: 34px; padding: 4px 6px; text-align: center; border-radius: 6px; background: #e3f4ea;
  color: var(--good); font-size: 13px; font-variant-numeric: tabular-nums; text-decoration: none; }
.seed.bad { background: #fbe6e4; color: var(--bad); font-weight: 700; }
td.plot { width: 430px; padding: 2px 10px 2px 0; vertical-align: middle; }
td.name { max-width: 300px; }
video { width: 640px; max-width: 100%; border-radius: 8px; margin-top: 10px; background: #10151f; display: block; }
)css";

/// RFC 4648.
std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(4 * (bytes.size() / 3 + 1));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t block = 0;
    for (std::size_t k = 0; k < 3; ++k)
      block = block << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[block >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

std::vector<std::string> split_at_quotes(const std::string& word) {
  std::vector<std::string> parts(1);
  for (const char c : word) {
    if (c == '\'')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// As a shell reads it back.
std::string shell_text(const std::vector<std::string>& words) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=:,+-";
  std::string text;
  for (const std::string& word : words) {
    const bool plain = !word.empty() && word.find_first_not_of(kPlain) == std::string::npos;
    text += text.empty() ? "" : " ";
    text += plain ? word : fmt::format("'{}'", fmt::join(split_at_quotes(word), "'\\''"));
  }
  return text;
}

Spread spread_over(const Robustness& robustness, double (*figure)(const Variation&)) {
  std::vector<double> values;
  for (const Variation& one : robustness.variations)
    if (one.ended_in_order()) values.push_back(figure(one));
  return spread_of(std::move(values));
}

double speed_of(const Variation& variation) {
  return variation.report->wall_time > 0.0 ? variation.sim_time() / variation.report->wall_time : 0.0;
}

void add_tile(std::string& page, const std::string& figure, const std::string& what) {
  page +=
      fmt::format(R"(<div class="tile"><b>{}</b><span class="soft">{}</span></div>)", xml_text(figure), xml_text(what));
}

/// The expectation that uses the greatest share of its upper bound.
void add_nearest(std::string& page, const std::vector<ExpectationSpread>& expectations) {
  double share = 0.0;
  const ExpectationSpread* nearest = nullptr;
  for (const ExpectationSpread& one : expectations) {
    const double used = one.upper && *one.upper > 0.0 ? one.spread().greatest / *one.upper : 0.0;
    if (used <= share) continue;
    share = used;
    nearest = &one;
  }
  if (nearest != nullptr) add_tile(page, fmt::format("{:.0f} %", 100.0 * share), "of its bound: " + nearest->name);
}

void add_head(std::string& page, const Robustness& robustness) {
  const bool holds = robustness.holds();
  page +=
      fmt::format(R"(<div class="card verdict{}"><h1>{} of {} variations passed</h1><p><b>{}</b><br>)",
                  holds ? "" : " bad", robustness.passed(), robustness.variations.size(), xml_text(robustness.title));
  page += fmt::format("<code>{}</code></p>", xml_text(robustness.file));
  page += fmt::format(
      "<p>{} had to pass. If seeds stand for what really varies, at least {:.0f} % of all variations "
      "pass, with 95 % confidence.{}</p></div>",
      robustness.needed, 100.0 * robustness.share_at_least(),
      robustness.all_ended_in_order() ? "" : " <b>Not every run ended in order.</b>");
}

void add_tiles(std::string& page, const Robustness& robustness, const std::vector<ExpectationSpread>& expectations) {
  const Spread time = spread_over(robustness, [](const Variation& one) { return one.sim_time(); });
  const Spread speed = spread_over(robustness, speed_of);
  page += R"(<div class="tiles">)";
  add_tile(page, fmt::format("{:.1f} ... {:.1f} s", time.least, time.greatest),
           fmt::format("simulated time, median {:.1f} s", time.median));
  add_nearest(page, expectations);
  add_tile(page, fmt::format("{:.1f} times", speed.median), "real time, median of the runs");
  add_tile(page, fmt::format("{:.0f} s", robustness.wall_s), fmt::format("for all, {} at a time", robustness.jobs));
  page += "</div>";
}

void add_seeds(std::string& page, const Robustness& robustness) {
  page += R"(<h2>Seeds</h2><div class="card seeds">)";
  for (const Variation& one : robustness.variations) {
    const std::string seed = std::to_string(one.seed);
    page += one.passed() ? fmt::format(R"(<span class="seed" title="{:.1f} s">{}</span>)", one.sim_time(), seed)
                         : fmt::format(R"(<a class="seed bad" href="#seed-{0}" title="{1}">{0}</a>)", seed,
                                       xml_text(one.message()));
  }
  page += "</div>";
}

void add_expectation(std::string& page, const ExpectationSpread& one) {
  const bool all = one.passed() == one.judged.size();
  const Spread spread = one.spread();
  page += fmt::format(
      R"(<tr><td><span class="mark {}">{}/{}</span></td><td class="name">{}<br><span class="soft">{}</span></td>)",
      all ? "good" : "bad", one.passed(), one.judged.size(), xml_text(one.name), xml_text(bounds_text(one)));
  page += fmt::format(R"(<td class="plot">{}</td><td class=number>{}</td><td class=number>{}</td></tr>)",
                      one.measures() ? strip_plot(one) : "", one.measures() ? amount_text(spread.median, one.unit) : "",
                      one.measures() ? amount_text(spread.greatest, one.unit) : "");
}

void add_expectations(std::string& page, const std::vector<ExpectationSpread>& expectations) {
  page += R"(<h2>Expectations</h2><div class="card"><table><tr><th>Passed</th><th>What</th>)"
          R"(<th>A dot for each seed; red lines are bounds</th><th class=number>Median</th>)"
          R"(<th class=number>Greatest</th></tr>)";
  for (const ExpectationSpread& one : expectations) add_expectation(page, one);
  page += "</table></div>";
}

void add_failure(std::string& page, const Variation& one) {
  page += fmt::format(
      R"(<div class="card verdict bad" id="seed-{0}"><b>Seed {0}</b>{1}<p>{2}</p>)", one.seed,
      one.ended_in_order() ? fmt::format(", ended after {:.1f} s", one.sim_time()) : ", <b>did not end in order</b>",
      xml_text(one.message()));
  page += fmt::format("<p>Again: <code>./takt {}</code></p>", xml_text(shell_text(one.command)));
  if (!one.film.empty()) {
    page += fmt::format(R"(<video controls muted loop preload="metadata" src="data:video/mp4;base64,{}"></video>)"
                        R"(<span class="soft">the last seconds</span>)",
                        base64(one.film));
  }
  page += "</div>";
}

}  // namespace

std::string to_html(const Robustness& robustness) {
  const auto expectations = robustness.expectations();
  std::string page = fmt::format(
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\"><title>{} variations of {}</title><style>",
      robustness.variations.size(), xml_text(robustness.title));
  page += record::kReportStyle;
  page += kPageStyle;
  page += "</style></head><body><main>";
  add_head(page, robustness);
  add_tiles(page, robustness, expectations);
  add_seeds(page, robustness);
  if (robustness.passed() < robustness.variations.size()) page += "<h2>What did not pass</h2>";
  for (const Variation& one : robustness.variations)
    if (!one.passed()) add_failure(page, one);
  add_expectations(page, expectations);
  return page + "</main></body></html>\n";
}

}  // namespace takt::tools
