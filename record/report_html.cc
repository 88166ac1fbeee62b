// The report for people: one page, nothing loaded from elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/base/output_file.h"
#include "core/base/xml_text.h"
#include "record/compare.h"
#include "record/report_parts.h"

namespace takt::record {

namespace {

/// More pictures than this make a page that nobody scrolls through; the table has all columns.
constexpr std::size_t kMostPictures = 80;

constexpr std::string_view kStyle = R"css(
:root { --ink: #1c2330; --soft: #667085; --line: #e4e7ec; --good: #16794c; --bad: #c0362c; }
* { box-sizing: border-box; }
body { margin: 0; background: #f6f7f9; color: var(--ink);
  font: 15px/1.5 "Inter", "DejaVu Sans", system-ui, sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 32px 24px 64px; }
h1 { font-size: 26px; margin: 0 0 4px; }
h2 { font-size: 18px; margin: 36px 0 12px; }
.card { background: #fff; border: 1px solid var(--line); border-radius: 10px; padding: 18px 22px; margin-bottom: 16px; }
.verdict { border-left: 6px solid var(--good); }
.verdict.bad { border-left-color: var(--bad); }
.verdict h1 { color: var(--good); }
.verdict.bad h1 { color: var(--bad); }
.soft { color: var(--soft); }
code { font: 13px "DejaVu Sans Mono", ui-monospace, monospace; background: #f1f3f6; border-radius: 4px;
  padding: 1px 5px; overflow-wrap: anywhere; }
ul { margin: 6px 0 0; padding-left: 20px; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
th { text-align: left; color: var(--soft); font-weight: 600; border-bottom: 2px solid var(--line);
  padding: 6px 10px 6px 0; }
td { border-bottom: 1px solid var(--line); padding: 5px 10px 5px 0; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.mark { display: inline-block; width: 68px; text-align: center; border-radius: 10px; font-size: 12px;
  font-weight: 600; }
.mark.good { background: #e3f4ea; color: var(--good); }
.mark.bad { background: #fbe6e4; color: var(--bad); }
.mark.none { background: #eef0f3; color: var(--soft); }
figure { margin: 0; }
figcaption { display: flex; justify-content: space-between; gap: 16px; margin-bottom: 6px; }
figcaption b { font-size: 15px; }
svg { width: 100%; height: auto; display: block; }
svg text { font: 11px "DejaVu Sans", system-ui, sans-serif; fill: #667085; }
details > summary { cursor: pointer; font-weight: 600; margin: 28px 0 12px; font-size: 18px; }
)css";

std::string sentence(std::string text) {
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

bool is_judged(const ColumnComparison& c) { return c.tolerance.kind != ToleranceKind::kReportOnly; }

std::string mark(const ColumnComparison& c) {
  if (!c.passed) return R"(<span class="mark bad">outside</span>)";
  return is_judged(c) ? R"(<span class="mark good">inside</span>)" : R"(<span class="mark none">shown</span>)";
}

std::string amount(double value, const std::string& unit) {
  if (std::isinf(value)) return "null against value";
  return fmt::format("{:.3g}{}", value, unit.empty() ? "" : " " + unit);
}

void add_list(std::string& page, std::string_view title, const std::vector<std::string>& items) {
  if (items.empty()) return;
  page += fmt::format("<p><b>{}</b></p><ul>", title);
  for (const std::string& item : items) page += fmt::format("<li>{}</li>", xml_text(item));
  page += "</ul>";
}

void add_verdict(std::string& page, const Comparison& c) {
  const std::string title = sentence(verdict_text(c));
  const auto failed = std::ranges::count(c.columns, false, &ColumnComparison::passed);
  page += fmt::format(R"(<div class="card verdict{}"><h1>{}</h1>)", c.passed ? "" : " bad", title);
  page += fmt::format("<p>A: <code>{}</code><br>B, the reference: <code>{}</code></p>", xml_text(c.name_a),
                      xml_text(c.name_b));
  page += fmt::format("<p>{} of {} columns judged are outside. {}.</p>", failed,
                      std::ranges::count_if(c.columns, is_judged), xml_text(sentence(digest_text(c))));
  add_list(page, "Missing", c.missing);
  add_list(page, "To know", c.notes);
  page += "</div>";
}

void add_row(std::string& page, const ColumnComparison& c) {
  page += fmt::format(
      "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=number>{}</td><td class=number>{:.3f} s</td>"
      "<td class=number>{}</td></tr>",
      mark(c), xml_text(c.topic), xml_text(c.column), xml_text(tolerance_text(c)), amount(c.max_deviation, c.unit),
      to_seconds(c.time), amount(c.max_difference, c.unit));
  std::string more = xml_text(c.note);
  for (const FeatureDifference& f : c.features) {
    more += fmt::format("{}{}: {:.4g} against {:.4g}{}", more.empty() ? "" : "; ", f.name, f.a, f.b,
                        f.passed ? "" : " (outside)");
  }
  if (!more.empty()) page += fmt::format(R"(<tr><td></td><td colspan=6 class="soft">{}</td></tr>)", more);
}

void add_table(std::string& page, const std::vector<const ColumnComparison*>& columns) {
  page += R"(<div class="card"><table><tr><th></th><th>Topic</th><th>Column</th><th>Tolerance</th>)"
          R"(<th class=number>Deviation</th><th class=number>at</th><th class=number>At equal times</th></tr>)";
  for (const ColumnComparison* c : columns) add_row(page, *c);
  page += "</table></div>";
}

void add_pictures(std::string& page, const std::vector<const ColumnComparison*>& columns, std::size_t& left) {
  for (const ColumnComparison* c : columns) {
    if (left == 0) break;
    if (c->curve_a.time_s.size() < 2) continue;
    --left;
    page += fmt::format(
        R"(<div class="card"><figure><figcaption><span><b>{}</b> <span class="soft">{}{}</span></span>)"
        R"(<span>{} {}</span></figcaption>{}</figure></div>)",
        xml_text(c->column), xml_text(c->topic), c->unit.empty() ? "" : ", " + xml_text(c->unit),
        c->curve_b.time_s.empty()
            ? R"(<span class="soft">equal to the bit</span>)"
            : fmt::format(R"(<span class="soft">deviation {} at {:.3f} s, tolerance {}</span>)",
                          amount(c->max_deviation, c->unit), to_seconds(c->time), xml_text(tolerance_text(*c))),
        mark(*c), draw_column(*c));
  }
}

}  // namespace

std::string to_html(const Comparison& comparison) {
  std::vector<const ColumnComparison*> failed, inside, shown;
  for (const ColumnComparison& c : comparison.columns) {
    (!c.passed ? failed : is_judged(c) ? inside : shown).push_back(&c);
  }
  const auto worst_first = [](std::vector<const ColumnComparison*>& columns) {
    std::ranges::stable_sort(columns, std::greater{}, [](const ColumnComparison* c) {
      return c->tolerance.dv > 0.0 ? c->max_deviation / c->tolerance.dv : c->max_deviation;
    });
  };
  worst_first(failed);

  std::string page =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\"><title>Two runs side by side</title><style>";
  page += kStyle;
  page += "</style></head><body><main>";
  add_verdict(page, comparison);
  std::size_t pictures = kMostPictures;
  if (!failed.empty()) {
    page += "<h2>Outside</h2>";
    add_table(page, failed);
    add_pictures(page, failed, pictures);
  }
  const auto add_folded = [&](std::string_view title, const std::vector<const ColumnComparison*>& columns) {
    if (columns.empty()) return;
    page += fmt::format("<details{}><summary>{} ({})</summary>", failed.empty() ? " open" : "", title, columns.size());
    add_table(page, columns);
    add_pictures(page, columns, pictures);
    page += "</details>";
  };
  add_folded("Inside", inside);
  add_folded("Shown, not judged", shown);
  page += "</main></body></html>\n";
  return page;
}

Result<void> write_report(const Comparison& comparison, const std::filesystem::path& path) {
  Diagnostics diagnostics = write_file(path, to_html(comparison), "--report");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return {};
}

}  // namespace takt::record
