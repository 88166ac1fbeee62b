#include "cell/file/copies.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 5> kWithParameters{"frames", "devices", "objects", "cameras", "expectations"};

bool is_parameter_name(std::string_view name) {
  const auto is_part = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return !name.empty() && std::isdigit(static_cast<unsigned char>(name[0])) == 0 && std::ranges::all_of(name, is_part);
}

/// What an expectation `value` is about is an expression like those of programs: it knows parameters as variables.
bool is_expression(const Json& entry, const std::string& key) {
  if (key != "value") return false;
  const auto kind = entry.find("kind");
  return kind != entry.end() && *kind == "value";
}

class CopyWriter {
 public:
  CopyWriter(Json& document, Diagnostics& diagnostics) : document_(document), diagnostics_(diagnostics) {}

  void write() {
    if (!document_.is_object()) return;
    read_parameters();
    for (const std::string_view part : kWithParameters) {
      const auto found = document_.find(part);
      if (found != document_.end()) fill_in(*found, "/" + std::string(part));
    }
    write_objects();
    write_expectations();
  }

 private:
  void read_parameters() {
    const auto found = document_.find("parameters");
    if (found == document_.end()) return read_ranges();
    if (!found->is_object()) {
      diagnostics_.error(Code::kWrongType, "/parameters", "unexpected value " + short_dump(*found),
                         "Give an object {...}");
    } else {
      for (const auto& [name, value] : found->items()) read_parameter(name, value);
    }
    document_.erase("parameters");
    read_ranges();
    declare_in_program();
  }

  void read_parameter(const std::string& name, const Json& value) {
    const std::string pointer = "/parameters" + pointer_segment(name);
    if (!is_parameter_name(name))
      diagnostics_.error(Code::kInvalidName, pointer, fmt::format("invalid name '{}'", name), kParameterName.hint);
    else if (!value.is_number() && !value.is_boolean() && !value.is_string())
      diagnostics_.error(Code::kWrongType, pointer, "unexpected value " + short_dump(value),
                         "Give a number, a text, true or false");
    else
      parameters_[name] = value;
  }

  /// What may be given to each parameter; whoever sets another value is told here and not by what follows from it.
  void read_ranges() {
    const auto found = document_.find("parameter_ranges");
    if (found == document_.end()) return;
    const Json ranges = std::move(*found);
    document_.erase("parameter_ranges");
    if (!ranges.is_object())
      return diagnostics_.error(Code::kWrongType, "/parameter_ranges", "unexpected value " + short_dump(ranges),
                                "Give an object {...}");
    ObjectReader values(parameters_, "/parameters", diagnostics_);
    for (const auto& [name, entry] : ranges.items()) {
      const std::string pointer = "/parameter_ranges" + pointer_segment(name);
      if (!parameters_.contains(name))
        diagnostics_.error(Code::kUnknownName, pointer, fmt::format("there is no parameter '{}'", name),
                           nearest_choice(name, parameter_names()));
      else if (!entry.is_object())
        diagnostics_.error(Code::kWrongType, pointer, "unexpected value " + short_dump(entry), "Give an object {...}");
      else
        check_range(name, entry, pointer, values);
    }
  }

  /// A value that is not allowed is replaced by one that is: what would follow from it is no finding of its own.
  void check_range(const std::string& name, const Json& entry, const std::string& pointer, ObjectReader& values) {
    const auto [range, whole, choices] = parameter_range_form().read(entry, pointer, diagnostics_);
    if (entry.contains("one_of")) {
      if (!choices.empty() && values.choice(name, choices).empty()) parameters_[name] = choices.front();
      return;
    }
    const std::size_t before = diagnostics_.list().size();
    const double value = whole ? static_cast<double>(values.integer(name, {}, range)) : values.number(name, {}, range);
    if (diagnostics_.list().size() == before) return;
    const double allowed = std::min(std::max(std::isfinite(value) ? value : 0.0, range.low), range.high);
    parameters_[name] = whole ? Json(static_cast<std::int64_t>(allowed)) : Json(allowed);
  }

  [[nodiscard]] std::vector<std::string> parameter_names() const {
    std::vector<std::string> names;
    for (const auto& [name, value] : parameters_.items()) names.push_back(name);
    return names;
  }

  /// A program that is one sequence gets them as variables; one that declares the name itself keeps its own.
  void declare_in_program() {
    const auto program = document_.find("program");
    if (program == document_.end() || !program->is_object() || program->value("do", Json()) != "sequence") return;
    Json& variables = (*program)["variables"];
    if (variables.is_null()) variables = Json::object();
    if (!variables.is_object()) return;
    for (const auto& [name, value] : parameters_.items())
      if (!variables.contains(name)) variables[name] = value;
  }

  void fill_in(Json& value, const std::string& pointer) {
    if (value.is_object()) {
      for (auto& [key, one] : value.items())
        if (!is_expression(value, key)) fill_in(one, pointer + pointer_segment(key));
    } else if (value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) fill_in(value[i], pointer + pointer_segment(i));
    } else if (value.is_string() && value.get_ref<const std::string&>().starts_with('$')) {
      const std::string name = value.get<std::string>().substr(1);
      const auto found = parameters_.find(name);
      if (found != parameters_.end()) {
        value = Json(*found);
      } else {
        diagnostics_.error(Code::kUnknownName, pointer, fmt::format("there is no parameter '{}'", name),
                           nearest_choice(name, parameter_names()));
      }
    }
  }

  void write_objects() {
    const auto found = document_.find("objects");
    if (found == document_.end() || !found->is_object()) return;
    Json written = Json::object();
    for (const auto& [name, entry] : found->items()) {
      const std::string pointer = "/objects" + pointer_segment(name);
      if (!has_copies(entry)) {
        written[name] = entry;
        continue;
      }
      if (name.find('#') == std::string::npos)
        diagnostics_.error(Code::kInvalidName, pointer, fmt::format("all copies of '{}' would have one name", name),
                           "Write '#' into the name: it becomes the number of the copy");
      for (auto& [number, copy] : copies_of(entry, pointer)) written[numbered(name, number)] = std::move(copy);
    }
    *found = std::move(written);
  }

  void write_expectations() {
    const auto found = document_.find("expectations");
    if (found == document_.end() || !found->is_array()) return;
    const bool any = std::ranges::any_of(*found, has_copies);
    if (!any) return;  // their pointers stay those of the file
    Json written = Json::array();
    for (std::size_t i = 0; i < found->size(); ++i) {
      const Json& entry = (*found)[i];
      if (!has_copies(entry)) {
        written.push_back(entry);
        continue;
      }
      for (auto& [number, copy] : copies_of(entry, "/expectations" + pointer_segment(i)))
        written.push_back(std::move(copy));
    }
    *found = std::move(written);
  }

  static bool has_copies(const Json& entry) { return entry.is_object() && entry.contains("copies"); }

  std::vector<std::pair<std::int64_t, Json>> copies_of(const Json& entry, const std::string& pointer) {
    std::vector<std::pair<std::int64_t, Json>> copies;
    const auto [count, step] = copies_form().read(entry["copies"], pointer + "/copies", diagnostics_);
    for (std::int64_t number = 1; number <= count; ++number) {
      Json copy = entry;
      copy.erase("copies");
      number_texts(copy, number);
      shift(copy, step, static_cast<double>(number - 1));
      copies.emplace_back(number, std::move(copy));
    }
    return copies;
  }

  static std::string numbered(std::string text, std::int64_t number) {
    for (std::size_t at = text.find('#'); at != std::string::npos; at = text.find('#', at + 1))
      text.replace(at, 1, std::to_string(number));
    return text;
  }

  static void number_texts(Json& value, std::int64_t number) {
    if (value.is_string()) value = numbered(value.get<std::string>(), number);
    if (value.is_structured())
      for (Json& one : value) number_texts(one, number);
  }

  /// An object by its place, all else by its own position; where none is said it is counted from the origin.
  static void shift(Json& copy, const Eigen::Vector3d& step, double steps) {
    const auto at = copy.find("at");
    Json& placed = at != copy.end() && at->is_object() ? *at : copy;
    if (step.isZero(0.0)) return;
    Json& position = placed["position_m"];
    if (position.is_null()) position = Json::array({0.0, 0.0, 0.0});
    for (std::size_t i = 0; i < 3 && position.is_array() && i < position.size(); ++i)
      if (position[i].is_number()) position[i] = position[i].get<double>() + steps * step[static_cast<Eigen::Index>(i)];
  }

  Json& document_;
  Diagnostics& diagnostics_;
  Json parameters_ = Json::object();
};

}  // namespace

const NameRule kParameterName{.pattern = "^[A-Za-z_][A-Za-z0-9_]*$",
                              .allows = is_parameter_name,
                              .hint = "Use letters, digits and '_', no digit first"};

const FormOf<Copies>& copies_form() {
  static const auto form =
      FormOf<Copies>("copies")
          .add(integer_key("count", {.low = 0, .high = 1000}, "How many; 0: none.").with_parameter(), &Copies::count)
          .add(vector_key("step_m", "m", "From one to the next, added to the position.").optional("none"),
               &Copies::step);
  return form;
}

const FormOf<ParameterRange>& parameter_range_form() {
  using Allowed = ParameterRange;
  static const auto form =
      FormOf<Allowed>("parameter_range")
          .add(number_key("at_least", "", kAnyNumber, "The smallest number.").optional("any"),
               [](Allowed& to) -> double& { return to.range.low; })
          .add(number_key("at_most", "", kAnyNumber, "The largest number.").optional("any"),
               [](Allowed& to) -> double& { return to.range.high; })
          .add(boolean_key("whole", "Only whole numbers.").optional(), &Allowed::whole)
          .add(texts_key("one_of", "The texts that are allowed; alone.", 1).optional(), &Allowed::choices)
          .rule(at_most_one({"one_of", "at_least"}))
          .rule(at_most_one({"one_of", "at_most"}))
          .then([](FormReader& from, Allowed& to) {
            if (to.range.low > to.range.high)
              from.diagnostics().error(Code::kOutOfRange, from.at("at_most"),
                                       fmt::format("{:g} is less than 'at_least'", to.range.high),
                                       fmt::format("Give a number of at least {:g}", to.range.low));
          });
  return form;
}

void write_out_copies(Json& document, Diagnostics& diagnostics) { CopyWriter(document, diagnostics).write(); }

}  // namespace takt::cell
