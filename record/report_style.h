#pragma once

#include <string_view>

namespace takt::record {

/// The style sheet of reports for people: one page, nothing loaded from elsewhere.
inline constexpr std::string_view kReportStyle = R"css(
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
.films { display: flex; gap: 16px; }
.films figure { flex: 1; }
video { width: 100%; display: block; border-radius: 6px; }
figcaption { display: flex; justify-content: space-between; gap: 16px; margin-bottom: 6px; }
figcaption b { font-size: 15px; }
svg.plot { width: 100%; height: auto; display: block; cursor: crosshair; user-select: none; }
svg.window * { vector-effect: non-scaling-stroke; }
.hint { color: var(--soft); font-size: 13px; }
svg text { font: 11px "DejaVu Sans", system-ui, sans-serif; fill: #667085; }
details > summary { cursor: pointer; font-weight: 600; margin: 28px 0 12px; font-size: 18px; }
)css";

}  // namespace takt::record
