#include "tools/net_text.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace takt::tools {
namespace {

using Row = std::vector<std::string>;

/// Rows in columns as wide as their widest entry; the first row is the heading. Nothing without further rows.
std::string table(const std::string& title, const std::vector<Row>& rows) {
  if (rows.size() < 2) return {};
  std::vector<std::size_t> widths(rows.front().size());
  for (const Row& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text = "\n" + title + "\n";
  for (const Row& row : rows) {
    std::string line = " ";
    for (std::size_t c = 0; c < row.size(); ++c) line += fmt::format(" {:<{}} ", row[c], widths[c]);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string way(const std::vector<std::string>& ports) {
  std::string text;
  for (const std::string& port : ports) text += (text.empty() ? "" : " > ") + port;
  return text;
}

std::string reactions(const net::NetReport& report) {
  std::vector<Row> rows = {{"from", "to", "fewest", "most", ""}};
  for (const auto& one : report.reactions) {
    std::string remark = one.data_dependent ? "and what depends on data" : "";
    if (!one.exact) remark += std::string(remark.empty() ? "" : ", ") + "upper bound";
    rows.push_back(
        {one.source, one.sink, std::to_string(one.minimum_cycles), std::to_string(one.maximum_cycles), remark});
  }
  return table("reaction certificate (cycles)", rows);
}

std::string demands(const net::NetReport& report) {
  std::vector<Row> rows = {{"from", "to", "demanded", "certified"}};
  for (const auto& one : report.demands) {
    rows.push_back({one.from, one.to, fmt::format("{} to {}", one.demanded_minimum, one.demanded_maximum),
                    fmt::format("{} to {}", one.minimum_cycles, one.maximum_cycles)});
  }
  return table("demanded bounds (cycles)", rows);
}

std::string null_paths(const net::NetReport& report) {
  std::vector<Row> rows = {{"at", "null means", "by way of"}};
  for (const auto& one : report.null_paths) {
    const std::string origin = one.origin.empty() ? "" : one.origin + ": ";
    rows.push_back({one.at, one.meaning, origin + way(one.ports)});
  }
  return table("where null can stop or drive something", rows);
}

std::string exclusions(const net::NetReport& report) {
  std::vector<Row> rows = {{"at", "never two at a time"}};
  for (const auto& one : report.exclusions)
    rows.push_back({one.at, one.proven ? "proven" : "not proven: a conflict fails the net"});
  return table("fragments that share a device or a merge", rows);
}

std::string free_units(const net::NetReport& report) {
  std::vector<Row> rows = {{"primitive", "variable"}};
  for (const auto& one : report.free_units) rows.push_back({one.primitive, one.variable});
  return table("units that nothing fixes, taken as 1", rows);
}

std::string order(const net::NetReport& report) {
  std::string text = "\norder of evaluation\n  ";
  std::size_t column = 2;
  for (const std::string& id : report.order) {
    if (column + id.size() > 100 && column > 2) {
      text += "\n  ";
      column = 2;
    }
    text += id + "  ";
    column += id.size() + 2;
  }
  return text + "\n";
}

}  // namespace

std::string to_text(const net::NetReport& report) {
  return reactions(report) + demands(report) + null_paths(report) + exclusions(report) + free_units(report) +
         order(report);
}

}  // namespace takt::tools
