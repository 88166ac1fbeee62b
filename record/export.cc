#include "record/export.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/output_file.h"

namespace takt::record {
namespace {

/// A cell of a line: in quotes where it has to be.
void put_cell(std::string& out, std::string_view text) {
  if (text.find_first_of(",\"\r\n") == text.npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

void put_number(std::string& out, double value) {
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(out), "{}", value);
}

void put_time(std::string& out, Nanoseconds time) {
  fmt::format_to(std::back_inserter(out), "{}.{:09}", time / kSecond, time % kSecond);
}

using Words = std::vector<std::string>;

/// What the numbers of a column stand for; empty: for themselves.
Words words_of(const Recording& recording, std::string_view topic, const std::string& column) {
  const ChannelInfo* channel = recording.find_channel(topic);
  const auto words = channel == nullptr ? std::map<std::string, std::string>::const_iterator()
                                        : channel->metadata.find("words:" + column);
  if (channel == nullptr || words == channel->metadata.end()) return {};
  const auto json = nlohmann::json::parse(words->second, nullptr, false);
  Words list;
  for (const auto& word : json.is_array() ? json : nlohmann::json::array())
    list.push_back(word.is_string() ? word.get<std::string>() : "");
  return list;
}

std::string_view word_at(const Words& words, double number) {
  const bool is_index = number >= 0.0 && number < static_cast<double>(words.size()) && number == std::floor(number);
  return is_index ? std::string_view(words[static_cast<std::size_t>(number)]) : std::string_view();
}

std::string csv_of(const Table& table, const std::vector<Words>& words) {
  std::string out = "time_s";
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    out += ',';
    const std::string& unit = table.units[i];
    put_cell(out, unit.empty() ? table.columns[i] : fmt::format("{} [{}]", table.columns[i], unit));
    if (words[i].empty()) continue;
    out += ',';
    put_cell(out, table.columns[i] + ".name");
  }
  out += "\r\n";
  for (std::size_t row = 0; row < table.time.size(); ++row) {
    put_time(out, table.time[row]);
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      out += ',';
      put_number(out, table.values[i][row]);
      if (words[i].empty()) continue;
      out += ',';
      put_cell(out, word_at(words[i], table.values[i][row]));
    }
    out += "\r\n";
  }
  return out;
}

std::string csv_of(const std::vector<RecordedEvent>& events) {
  std::string out = "time_s,cycle,source,name,step,text\r\n";
  for (const RecordedEvent& event : events) {
    put_time(out, event.time);
    fmt::format_to(std::back_inserter(out), ",{}", event.cycle);
    for (const std::string* text : {&event.source, &event.name, &event.step, &event.text}) {
      out += ',';
      put_cell(out, *text);
    }
    out += "\r\n";
  }
  return out;
}

Result<void> written(const std::filesystem::path& file, const std::string& content) {
  Diagnostics diagnostics = write_file(file, content);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return {};
}

}  // namespace

Result<void> write_csv(const Recording& recording, std::string_view topic, const std::filesystem::path& file) {
  const auto topics = recording.event_topics();
  if (std::ranges::find(topics, topic) != topics.end()) {
    const auto events = recording.events(topic);
    if (!events) return std::unexpected(events.error());
    return written(file, csv_of(*events));
  }
  const auto table = recording.table(topic);
  if (!table) return std::unexpected(table.error());
  std::vector<Words> words;
  for (const std::string& column : table->columns) words.push_back(words_of(recording, topic, column));
  return written(file, csv_of(*table, words));
}

Result<void> write_tum(const Recording& recording, std::string_view topic, const std::string& frame,
                       const std::filesystem::path& file) {
  const auto header = recording.header(topic);
  if (!header) return std::unexpected(header.error());
  std::vector<std::size_t> columns;
  for (const char* part : {".x", ".y", ".z", ".qx", ".qy", ".qz", ".qw"}) {
    const auto found = std::ranges::find(header->columns, frame + part);
    if (found != header->columns.end()) columns.push_back(static_cast<std::size_t>(found - header->columns.begin()));
  }
  if (columns.size() != 7) {
    std::vector<std::string> frames;
    for (const std::string& column : header->columns)
      if (column.ends_with(".qw")) frames.push_back(column.substr(0, column.size() - 3));
    return failure(Code::kUnknownName, "", fmt::format("topic '{}' has no frame '{}'", topic, frame),
                   nearest_choice(frame, frames, 40));
  }
  const ColumnChoice choice{.topic = std::string(topic), .columns = columns};
  const auto tables = recording.tables(std::span(&choice, 1));
  if (!tables) return std::unexpected(tables.error());
  std::string out;
  const Table& table = tables->front();
  for (std::size_t row = 0; row < table.time.size(); ++row) {
    put_time(out, table.time[row]);
    for (const auto& column : table.values) fmt::format_to(std::back_inserter(out), " {}", column[row]);
    out += '\n';
  }
  return written(file, out);
}

std::string file_name_of(std::string_view topic) {
  std::string name;
  for (const char c : topic) {
    const bool keeps = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.';
    if (keeps || !name.empty()) name += keeps ? c : '_';
  }
  return name.empty() ? "topic" : name;
}

}  // namespace takt::record
