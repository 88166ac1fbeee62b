// What a scenario file says of its film and of the tolerances of its recordings.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenario/cell_tables.h"

namespace takt::scenario {
namespace {

struct FilmMark {
  const char* name;
  bool FilmShow::*shown;
  const char* doc;
};

constexpr FilmMark kFilmMarks[] = {
    {"traces", &FilmShow::traces, "paths of the tool centre points"},
    {"beams", &FilmShow::beams, "beams of sensors"},
    {"forces", &FilmShow::forces, "contact forces on machines as arrows"},
    {"commanded", &FilmShow::commanded, "machines where they are commanded to be, where they are not there"},
    {"frames", &FilmShow::frames, "frames of the file and tool centre points"}};

std::vector<std::string> mark_names() {
  std::vector<std::string> names;
  for (const FilmMark& mark : kFilmMarks) names.emplace_back(mark.name);
  return names;
}

table::Field show_field() {
  table::Field mark = table::field({}, table::Field::Type::kChoice, {});
  mark.choices = mark_names();
  std::string doc = "Marks beside the scene: ", shown;
  for (const FilmMark& one : kFilmMarks) {
    doc += fmt::format("{}{}, {}", &one == kFilmMarks ? "" : "; ", one.name, one.doc);
    if (FilmShow().*one.shown) shown += fmt::format("{}{}", shown.empty() ? "" : ", ", one.name);
  }
  table::Field show = table::field("show", table::Field::Type::kList, doc + ".");
  show.items = {std::move(mark)};
  show.fallback = shown;
  return show;
}

const table::Table<FilmEntry::Cut>& cut_table() {
  using Cut = FilmEntry::Cut;
  static const auto table = [] {
    table::Table<Cut> cut;
    cut.named(
           "step", table::NameOf::kStep, &Cut::step,
           "Name of the step; OUTER / STEP is one in another node, NAME (2) in its second round. Of several cuts that "
           "fit the first counts.")
        .required()
        .named("camera", table::NameOf::kCamera, &Cut::camera, "Camera from then on.")
        .required();
    return cut;
  }();
  return table;
}

using ToleranceTable = table::Table<record::ToleranceRule>;
using record::ToleranceKind;

void read_features(const table::Field& row, const table::Context& from, record::ToleranceRule& rule) {
  if (!from.reader.has(row.key)) return;
  rule.tolerance.features.reset();
  const std::vector<std::string> names = from.reader.texts(row.key);
  for (std::size_t k = 0; k < names.size(); ++k)
    record::judge_feature(names[k], from.reader.at(row.key) + pointer_segment(k), rule.tolerance.features,
                          from.reader.diagnostics());
}

void add_width(ToleranceTable& width) {
  width
      .number(
          "dv", "", [](record::ToleranceRule & rule) -> auto& { return rule.tolerance.dv; }, kNotNegative,
          "Half width in the column's unit.")
      .required()
      .value(
          "dt_s", table::seconds_type({.low = 0.0, .high = 10.0}),
          [](record::ToleranceRule & rule) -> auto& { return rule.tolerance.dt; },
          "Half width in time; of events the window; of the features settling and duration how far they may be off.");
}

table::Field features_field() {
  table::Field feature = table::field({}, table::Field::Type::kChoice, {});
  std::string judged;
  for (std::size_t i = 0; i < record::kFeatureCount; ++i) {
    feature.choices.emplace_back(name_of(static_cast<record::Feature>(i)));
    if (record::Tolerance().features.test(i)) judged += (judged.empty() ? "" : ", ") + feature.choices.back();
  }
  table::Field features = table::field(
      "features", table::Field::Type::kList,
      "Which are judged. peak: greatest magnitude; settling: from when on the curve stays within dv of its last value; "
      "path: its way up and down without turns smaller than dv, within 2 dv for each turn; duration: from its first "
      "value to its last.");
  features.items = {std::move(feature)};
  features.fallback = judged;
  return features;
}

}  // namespace

const table::Table<FilmEntry>& film_table() {
  using F = FilmEntry;
  static const auto table = [] {
    table::Table<F> film;
    film.named("camera", table::NameOf::kCamera, &F::camera,
               "Camera at the start. `fit`: one that fits the cell, also the default of a file without cameras.")
        .fallback("the first one")
        .named("inset", table::NameOf::kCamera, &F::inset, "Second camera, shown small in the upper right corner.")
        .named("force_sensor", table::NameOf::kSensor, &F::force_sensor,
               "Force/torque sensor whose contact force is shown.")
        .number("force_limit_N", "N", &F::force_limit_N, kPositive, "Force that is marked in the bar.")
        .object(show_field(),
                [](const table::Field& row, const table::Context& from, F& entry) {
                  if (from.reader.has(row.key))
                    choose_marks(from.reader.texts(row.key), from.reader.at(row.key), entry.show,
                                 from.reader.diagnostics());
                })
        .number(
            "trace_s", "s", [](F & entry) -> auto& { return entry.show.trace_s; }, {.low = 0.0, .high = 1e6},
            "How long a path stays.")
        .elements("cuts", {}, cut_table(), &F::cuts,
                  "Changes of camera: each takes effect when a step of that name starts.");
    return film;
  }();
  return table;
}

void choose_marks(const std::vector<std::string>& names, const std::string& pointer, FilmShow& show,
                  Diagnostics& diagnostics) {
  for (const FilmMark& mark : kFilmMarks) show.*mark.shown = std::ranges::find(names, mark.name) != names.end();
  const std::vector<std::string> known = mark_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(known, names[i]) != known.end()) continue;
    diagnostics.error(Code::kUnknownName, pointer + (pointer.starts_with('/') ? pointer_segment(i) : ""),
                      fmt::format("a film shows no '{}'", names[i]), nearest_choice(names[i], known));
  }
}

const ToleranceTable& tolerance_table() {
  using T = record::ToleranceRule;
  static const auto tube = [] {
    ToleranceTable width;
    add_width(width);
    return width;
  }();
  static const auto features = [] {
    ToleranceTable width;
    add_width(width);
    width.object(features_field(), read_features);
    return width;
  }();
  static const auto table = [] {
    ToleranceTable tolerance;
    tolerance
        .text("topic", &T::topic,
              "Topics of the recording, '*' for any characters: \"/arm/*\"; \"/program\" with column \"events\".")
        .text("column", &T::column, "Columns, '*' for any characters: \"*.effort\", \"force.*\".")
        .choose<ToleranceKind>(
            "kind", [](T & rule) -> auto& { return rule.tolerance.kind; },
            {{"exact", ToleranceKind::kExact},
             {"tube", ToleranceKind::kTube, {}, &tube},
             {"features", ToleranceKind::kFeatures, {}, &features},
             {"report_only", ToleranceKind::kReportOnly}},
            "exact: bit for bit; tube: within dv of a value of the reference within dt_s; features: only what "
            "`features` names, values within dv, times within dt_s; report_only: not judged.");
    return tolerance;
  }();
  return table;
}

}  // namespace takt::scenario
