// The report for people: one page, nothing loaded from elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/base/output_file.h"
#include "core/base/xml_text.h"
#include "record/compare.h"
#include "record/report_parts.h"
#include "record/report_script.h"
#include "record/report_style.h"

namespace takt::record {

namespace {

/// More pictures than this make a page that nobody scrolls through; the table has all columns.
constexpr std::size_t kMostPictures = 40;

std::string sentence(std::string text) {
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
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
  if (c.departure) page += fmt::format("<p><b>First departure</b> {}</p>", xml_text(departure_text(*c.departure)));
  page += fmt::format("<p>Judged: {}.</p>", xml_text(share_text(c)));
  add_list(page, "Missing", c.missing);
  std::vector<std::string> durations, differences;
  for (const StepDuration* step : other_durations(c)) durations.push_back(duration_text(*step));
  durations.resize(std::min<std::size_t>(durations.size(), 100));
  for (const ScenarioDifference& one : c.scenario_differences) differences.push_back(difference_text(one));
  add_list(page, "Steps that took another time", durations);
  add_list(page, "Scenarios", differences);
  add_list(page, "To know", c.notes);
  page += "</div>";
}

/// Both films side by side; one button plays both.
void add_films(std::string& page, const Comparison& c) {
  if (c.film_a.empty() && c.film_b.empty()) return;
  page += R"(<div class="card"><div class="films">)";
  for (const auto& [name, film] : {std::pair{"A", &c.film_a}, {"B, the reference", &c.film_b}})
    page += fmt::format(R"(<figure><figcaption><b>{}</b></figcaption>)"
                        R"(<video controls muted src="data:video/mp4;base64,{}"></video></figure>)",
                        name, base64(*film));
  page += "</div></div>";
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
                        f.passed ? (f.judged ? "" : " (not judged)") : " (outside)");
  }
  if (!more.empty()) page += fmt::format(R"(<tr><td></td><td colspan=6 class="soft">{}</td></tr>)", more);
}

void add_table(std::string& page, const std::vector<const ColumnComparison*>& columns) {
  page += R"(<div class="card"><table><tr><th></th><th>Topic</th><th>Column</th><th>Tolerance</th>)"
          R"(<th class=number>Deviation</th><th class=number>at</th><th class=number>At equal times</th></tr>)";
  for (const ColumnComparison* c : columns) add_row(page, *c);
  page += "</table></div>";
}

void add_pictures(std::string& page, const std::vector<const ColumnComparison*>& columns,
                  const std::vector<StepMark>& steps, std::size_t& left) {
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
        mark(*c), draw_column(*c, steps));
  }
}

}  // namespace

std::string to_html(const Comparison& comparison) {
  std::vector<const ColumnComparison*> inside, shown;
  for (const ColumnComparison& c : comparison.columns)
    if (c.passed) (is_judged(c) ? inside : shown).push_back(&c);
  const auto failed = failed_columns(comparison);

  std::string page =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\"><title>Two runs side by side</title><style>";
  page += kReportStyle;
  page += "</style></head><body><main>";
  add_verdict(page, comparison);
  add_films(page, comparison);
  page += R"(<p class="hint">Drag over a picture: all pictures show that time. Double click: all of it. )";
  page += "A click sets a mark to measure from.</p>";
  std::size_t pictures = kMostPictures;
  if (!failed.empty()) {
    page += "<h2>Outside</h2>";
    add_table(page, failed);
    add_pictures(page, failed, comparison.steps, pictures);
  }
  const auto add_folded = [&](std::string_view title, const std::vector<const ColumnComparison*>& columns) {
    if (columns.empty()) return;
    page += fmt::format("<details{}><summary>{} ({})</summary>", failed.empty() ? " open" : "", title, columns.size());
    add_table(page, columns);
    add_pictures(page, columns, comparison.steps, pictures);
    page += "</details>";
  };
  add_folded("Inside", inside);
  add_folded("Shown, not judged", shown);
  page += "<script>";
  page += kReportScript;
  page += "</script></main></body></html>\n";
  return page;
}

Result<void> write_report(const Comparison& comparison, const std::filesystem::path& path) {
  Diagnostics diagnostics = write_file(path, to_html(comparison), "--report");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return {};
}

}  // namespace takt::record
