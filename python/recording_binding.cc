// Recordings: channels as numpy without a copy, events, digests, comparison.
#include <memory>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <nlohmann/json.hpp>

#include "cell/judge/run_report.h"
#include "python/bindings.h"
#include "python/errors.h"
#include "record/compare.h"
#include "record/mcap_reader.h"
#include "record/recorder.h"
#include "record/recording.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Json = nlohmann::ordered_json;
using record::Recording;

/// An array of numpy over the numbers of a vector, which lives as long as the array does.
nb::object to_array(std::vector<double> values) {
  auto* kept = new std::vector<double>(std::move(values));
  const nb::capsule owner(kept, [](void* pointer) noexcept { delete static_cast<std::vector<double>*>(pointer); });
  return nb::cast(nb::ndarray<nb::numpy, double, nb::ndim<1>>(kept->data(), {kept->size()}, owner));
}

std::vector<double> seconds_of(const std::vector<Nanoseconds>& times) {
  std::vector<double> seconds;
  seconds.reserve(times.size());
  for (const Nanoseconds time : times) seconds.push_back(to_seconds(time));
  return seconds;
}

template <class T>
T required(Result<T> result) {
  if (!result) raise_error("RecordingError", std::move(result.error()));
  return std::move(*result);
}

std::shared_ptr<Recording> open_recording(const std::string& path) {
  const nb::gil_scoped_release unlocked;
  return std::make_shared<Recording>(required(Recording::open(path)));
}

/// What is in it, as JSON: topics with columns, units and numbers of rows; topics of events; metadata; damage.
std::string contents(const Recording& recording) {
  const nb::gil_scoped_release unlocked;
  Json tables = Json::array();
  for (const std::string& topic : recording.table_topics()) {
    const record::Table header = required(recording.header(topic));
    tables.push_back(
        {{"topic", topic}, {"columns", header.columns}, {"units", header.units}, {"rows", recording.rows(topic)}});
  }
  return cell::to_output_text({{"tables", tables},
                               {"events", recording.event_topics()},
                               {"metadata", recording.metadata()},
                               {"damage", recording.damage()},
                               {"start", to_seconds(recording.start_time())},
                               {"end", to_seconds(recording.end_time())}});
}

/// Time in s, and the columns in the order of the header.
nb::tuple to_tuple(record::Table table) {
  nb::list columns;
  for (std::vector<double>& column : table.values) columns.append(to_array(std::move(column)));
  return nb::make_tuple(to_array(seconds_of(table.time)), columns);
}

Result<std::vector<record::Table>> read_all(const Recording& recording, const std::vector<std::string>& topics) {
  std::vector<record::ColumnChoice> wanted;
  std::size_t values = 0;
  for (const std::string& topic : topics) {
    values += (required(recording.header(topic)).columns.size() + 1) * recording.rows(topic);
    wanted.push_back({.topic = topic});
  }
  if (values > record::mcap::ReadLimits::kTableValues) {
    Diagnostics wrong;
    wrong.error(Code::kTooLarge, "", "all topics together have too many values", "Give one topic at a time");
    return std::unexpected(std::move(wrong));
  }
  return recording.tables(wanted);
}

/// The file is read once, however many topics there are.
nb::typed<nb::list, nb::tuple> read_tables(const Recording& recording, const std::vector<std::string>& topics) {
  std::vector<record::Table> read;
  {
    const nb::gil_scoped_release unlocked;
    if (topics.size() == 1)
      read.push_back(required(recording.table(topics.front())));
    else
      read = required(read_all(recording, topics));
  }
  nb::list list;
  for (record::Table& table : read) list.append(to_tuple(std::move(table)));
  return list;
}

std::string events(const Recording& recording, const std::string& topic) {
  const nb::gil_scoped_release unlocked;
  Json list = Json::array();
  for (const record::RecordedEvent& one : required(recording.events(topic)))
    list.push_back({{"time", to_seconds(one.time)},
                    {"cycle", one.cycle},
                    {"source", one.source},
                    {"name", one.name},
                    {"text", one.text},
                    {"step", one.step}});
  return cell::to_output_text({{"events", list}});
}

/// The comparison as JSON, with its text for people. @param equal_digests  one differing bit is a failure
std::string compare(const std::string& a, const std::string& b, bool equal_digests, const std::string& report) {
  const nb::gil_scoped_release unlocked;
  record::CompareOptions options;
  options.require_equal_digests = equal_digests;
  if (report.empty()) options.plot_points = 0;
  const auto comparison = required(record::compare_recordings(a, b, options));
  if (!report.empty()) {
    const auto written = record::write_report(comparison, report);
    if (!written) raise_error("RecordingError", written.error());
  }
  Json json = record::to_json(comparison);
  json["text"] = record::to_text(comparison);
  return cell::to_output_text(std::move(json));
}

}  // namespace

void bind_recordings(nb::module_& module) {
  nb::class_<Recording>(module, "Recording").def("contents", contents).def("tables", read_tables).def("events", events);
  module.def("open_recording", open_recording);
  module.def("compare", compare);
  module.def(
      "fingerprint", [] { return record::fingerprint(); }, "What the bits of a run depend on.");
}

}  // namespace takt::python
