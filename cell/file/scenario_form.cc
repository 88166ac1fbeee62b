#include <algorithm>
#include <cmath>

#include "cell/file/copies.h"
#include "cell/file/forms.h"
#include "core/device/channel_file.h"
#include "core/device/material.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

const FormOf<CollisionsEntry::Allowed>& allowed_form() {
  using Allowed = CollisionsEntry::Allowed;
  static const auto form =
      FormOf<Allowed>("allowed_contact")
          .add(pair_key("between", "Two devices, objects or bodies (`arm/link_3`)."), &Allowed::between)
          .add(text_key("reason", "Why they may meet, for who reads the file.", 1), &Allowed::reason)
          .then([](FormReader& from, Allowed& allowed) { allowed.pointer = from.pointer(); });
  return form;
}

const FormOf<record::ToleranceRule>& tolerance_form() {
  using Rule = record::ToleranceRule;
  using Kind = record::ToleranceKind;
  using Form = FormOf<Rule>;
  const auto width = [](const char* of_value, const char* of_time) {
    return Form("", "")
        .add(number_key("dv", "", kNotNegative, of_value), [](Rule& rule) -> double& { return rule.tolerance.dv; })
        .add(number_key("dt_s", "s", {.low = 0.0, .high = 10.0}, of_time).optional(),
             [](Rule& rule) -> Nanoseconds& { return rule.tolerance.dt; });
  };
  static const auto form =
      Form("tolerance")
          .add(text_key("topic",
                        "Topics of the recording, '*' for any characters: \"/arm/*\"; \"/program\" with column "
                        "\"events\".")
                   .optional(),
               &Rule::topic)
          .add(text_key("column", "Columns, '*' for any characters: \"*.effort\", \"force.*\".").optional(),
               &Rule::column)
          .kinds(
              choice_key("kind", {},
                         "exact: bit for bit; tube: within dv of a value of the reference within dt_s; features: only "
                         "what `features` names, values within dv, times within dt_s; report_only: not judged.")
                  .by_default("tube"),
              [](Rule& rule) -> Kind& { return rule.tolerance.kind; },
              Form::KindList<Kind>{
                  {"exact", Kind::kExact, Form()},
                  {"tube", Kind::kTube,
                   width("Half width in the column's unit.", "Half width in time; of events the window.")},
                  {"features", Kind::kFeatures,
                   width("How far features may be off, in the column's unit.",
                         "How far settling and duration may be off.")
                       .add(list_key("features", 0, choice_key("", record::feature_names(), ""),
                                     "Which are judged. peak: greatest magnitude; settling: from when on the curve "
                                     "stays within dv of its last value; path: its way up and down without turns "
                                     "smaller than dv, within 2 dv for each turn; duration: from its first value to "
                                     "its last.")
                                .by_default(std::vector<std::string>{"max", "min", "mean", "end"}),
                            [](FormReader& from, Rule& rule) {
                              if (!from.has("features")) return;
                              rule.tolerance.features.reset();
                              const std::vector<std::string> names = from.texts("features");
                              for (std::size_t i = 0; i < names.size(); ++i)
                                record::judge_feature(names[i], from.at("features") + pointer_segment(i),
                                                      rule.tolerance.features, from.diagnostics());
                            })},
                  {"report_only", Kind::kReportOnly, Form()}});
  return form;
}

/// An entry of a list whose kinds are known later: what is wrong with it is reported there.
template <class Read>
void read_entries(FormReader& from, std::string_view key, const Read& read) {
  from.elements(key, [&](const Json& json, const std::string& pointer) {
    Diagnostics unread;
    ObjectReader entry(json, pointer, json.is_object() ? unread : from.diagnostics());
    if (json.is_object()) read(entry, json, pointer);
  });
}

void read_expectations(FormReader& from, Description& to) {
  read_entries(from, "expectations", [&](ObjectReader& entry, const Json& json, const std::string& pointer) {
    const std::string kind = entry.text("kind", "");
    to.expectations.push_back({entry.text("name", kind), kind, pointer, json});
  });
}

/// In the order of their times.
void read_faults(FormReader& from, Description& to) {
  read_entries(from, "faults", [&](ObjectReader& entry, const Json& json, const std::string& pointer) {
    const double seconds = std::clamp(entry.number("at_s", 0.0), 0.0, kLongestRun);
    const std::string sensor = entry.text("sensor", "");
    to.faults.push_back({.at = static_cast<Nanoseconds>(std::llround(1e9 * seconds)),
                         .kind = entry.text("do", FaultEntry::kDefaultKind),
                         .device = sensor.empty() ? entry.text("device", "") : sensor,
                         .pointer = pointer,
                         .json = json});
  });
  std::ranges::stable_sort(to.faults, {}, &FaultEntry::at);
  for (DeviceEntry& device : to.devices)
    device.may_fail = std::ranges::any_of(to.faults, [&](const FaultEntry& fault) {
      return fault.device.substr(0, fault.device.find('/')) == device.name;  // "BLOCK/TERMINAL" too
    });
}

void add_run(FormOf<Description>& form) {
  using D = Description;
  form.add(text_key("title", "Title in the film and in reports.").optional("name of the file"), &D::title)
      .add(text_key("description", "Text for readers of the file.").optional(),
           [](FormReader& from, D&) { (void)from.text("description"); })
      .add(integer_key("seed", kNotNegative, "Seed of all random draws: object poses, sensor noise, sensor offsets.")
               .optional(),
           &D::seed)
      .add(number_key("time_limit_s", "s", {.low = 0.0, .high = kLongestRun, .low_open = true},
                      "Simulated time; a run that takes longer is an error.")
               .optional(),
           &D::time_limit_s)
      .add(integer_key("program_latency_cycles", {.low = 0, .high = 1000},
                       "Cycles between a command of the program and its effect.")
               .optional(),
           &D::program_latency_cycles)
      .add(number_key("physics_step_ms", "ms", kAnyNumber,
                      "Step of the simulated physics: of the whole world, for all of the run.")
               .with_values({1, 0.5, 0.25})
               .optional(),
           &D::physics_step)
      .add(number_key("plant_mass_scale", "", {.low = 0.5, .high = 2.0},
                      "Factor on the masses of the simulated machines; their controllers keep the nominal masses.")
               .optional(),
           &D::plant_mass_scale);
}

void add_cell(FormOf<Description>& form) {
  using D = Description;
  form.add(members_key("frames", kCellName, frame_form(), "Poses by name, to be used as 'in'.").optional(), &D::frames)
      .add(members_key("parameters", any_of_key("", {"number", "string", "boolean"}, ""),
                       "Numbers, texts and Booleans by name. Outside of programs a text \"$NAME\" is the value of that "
                       "parameter; a program that is one sequence has them as variables.")
               .with_names(kParameterName)
               .optional())
      .add(members_key("parameter_ranges", object_key("", parameter_range_form().form(), ""),
                       "What may be given to a parameter, by its name.")
               .optional())
      .add(members_key("devices", kCellName, device_form(),
                       "Arms, bases, sensors, tools, grippers and I/O blocks by name.")
               .optional(),
           &D::devices)
      .add(members_key("composed", texts_key("", "", 1),
                       "Composed devices: name to the names of its devices, signals or other composed devices. A net "
                       "can hold it as one device (docs/devices/composed.md).")
               .with_names(kCellName)
               .optional(),
           [](FormReader& from, D& to) {
             from.members("composed", [&](const std::string& name, const Json& parts, const std::string& pointer) {
               // A reader of this member alone: it searches, and there may be many.
               const Json one = Json::object({{name, parts}});
               ObjectReader wholes(one, from.at("composed"), from.diagnostics());
               to.composed.push_back({name, pointer, wholes.texts(name)});
               if (to.composed.back().parts.empty())
                 from.diagnostics().error(Code::kMissing, pointer, "no part is given", "Name at least one device");
             });
           })
      .add(members_key("objects", kCellName, object_form(), "Physical objects by name.").optional(), &D::objects)
      .add(members_key("materials", object_key("", device::material_form(), ""),
                       "Surfaces beyond those of models/materials.json, by name; a known name is replaced "
                       "(docs/contacts.md).")
               .with_comments()
               .optional(),
           &D::materials)
      .add(objects_key("contacts", 0, device::contact_rule_form(),
                       "What two materials do together where it is not what follows from the two.")
               .optional(),
           &D::contacts)
      .add(object_key("collisions", collisions_form(), "").optional(), &D::collisions)
      .add(members_key("cameras", kCellName, camera_form(), "Cameras by name.").optional(), &D::cameras)
      .add(object_key("film", film_form(), "").optional(), &D::film)
      .add(members_key("channels", object_key("", device::channel_form().form(), ""),
                       "Values that nets exchange with each other and with the outside, by name (docs/channels.md).")
               .with_names(kCellName)
               .optional(),
           [](FormReader& from, D& to) {
             from.members("channels", [&](const std::string& name, const Json& json, const std::string& pointer) {
               to.channels.push_back(device::channel_from_json(name, json, pointer, from.diagnostics()));
             });
           });
}

void add_program(FormOf<Description>& form, ReadFor purpose) {
  using D = Description;
  Key program = any_key("program", "step", "What the cell does: one step, usually a sequence.");
  program.required = purpose == ReadFor::kScenario;
  form.add(
          members_key("nets", any_of_key("", {"string", "object"}, ""),
                      "Nets written by hand, by name, for the step 'net': the net itself, or its file in the folder of "
                      "the scenario or below (docs/nets.md).")
              .optional(),
          [](FormReader& from, D&) { (void)from.json("nets"); })  // read by read_nets()
      .add(std::move(program),
           [required = purpose == ReadFor::kScenario](FormReader& from, D& to) {
             if (const Json* json = from.object().object("program", required)) to.program = *json;
           })
      .add(members_key("programs", any_key("", "sub_program", ""),
                       "Programs that the step 'call' runs, by name (docs/programs.md).")
               .optional(),
           &D::programs)
      .add(list_key("faults", 0, any_key("", "fault", ""),
                    "Faults and actions at the cabinet during the run, at given times.")
               .optional(),
           read_faults)
      .add(objects_key("operator", 0, operator_form(), "What an operator does at the panel while the program runs.")
               .optional(),
           &D::operator_script)
      .add(object_key("golden", golden_form(),
                      "How closely runs have to follow the golden of this scenario (takt bless), and its recordings "
                      "each other (takt compare).")
               .optional(),
           &D::tolerances)
      .add(list_key("expectations", 0, any_key("", "expectation", ""),
                    "Statements about the run; the verdict is 'passed' if all are true.")
               .optional(),
           read_expectations);
}

FormOf<Description> form_for(ReadFor purpose) {
  FormOf<Description> form("",
                           "A cell, the program that it runs, and the expected results (docs/scenarios.md). Whatever "
                           "needs the models (joints, reach, names) is checked by 'takt validate'.");
  add_run(form);
  add_cell(form);
  add_program(form, purpose);
  return form;
}

}  // namespace

const FormOf<CollisionsEntry>& collisions_form() {
  using Entry = CollisionsEntry;
  static const auto form =
      FormOf<Entry>("collisions",
                    "Checks of collisions, in the rehearsal and in the run (docs/world.md). Without it: on, with the "
                    "defaults.")
          .add(number_key("margin_m", "m", {.low = 1e-5, .high = 0.1}, "Bodies that come nearer to each other collide.")
                   .optional(),
               &Entry::margin_m)
          .add(objects_key("allow", 0, allowed_form(), "Pairs that may meet.").optional(), &Entry::allow)
          .then([](FormReader&, Entry& entry) {
            std::erase_if(entry.allow, [](const Entry::Allowed& pair) { return pair.between.size() != 2; });
          })
          .add(text_key("off", "Nothing is checked, for this reason.", 1).optional(), &Entry::off);
  return form;
}

const FormOf<std::vector<record::ToleranceRule>>& golden_form() {
  static const auto form = FormOf<std::vector<record::ToleranceRule>>().add(
      objects_key("tolerances", 0, tolerance_form(),
                  "The first one that fits a column counts; without one the unit of the column decides "
                  "(docs/recording.md#comparing)."),
      std::identity());
  return form;
}

const FormOf<Description>& scenario_form(ReadFor purpose) {
  static const FormOf<Description> whole = form_for(ReadFor::kScenario), cell = form_for(ReadFor::kCell);
  return purpose == ReadFor::kScenario ? whole : cell;
}

}  // namespace takt::cell
