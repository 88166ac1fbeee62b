// Arithmetic, lists and strings.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/LU>

#include "core/base/random.h"
#include "languages/urscript/arguments.h"
#include "languages/urscript/functions.h"
#include "languages/urscript/poses.h"

namespace takt::languages::urscript {

namespace {

constexpr int kLongestMade = 10'000;

void add_real(Library& library, const char* signature, double (*function)(double)) {
  library.add(signature, checked([function](const Arguments& a) -> Outcome {
                const double value = function(a.real(0));
                if (!std::isfinite(value)) throw BadArgument{"no real number comes of it"};
                return Value(value);
              }));
}

const List& list_at(const Arguments& a, std::size_t i) {
  if (const auto* list = a[i].get<List>()) return *list;
  throw BadArgument{fmt::format("argument {} is {}, expected a list", i + 1, a[i].kind())};
}

std::size_t length_of(const Value& value) {
  if (const auto* list = value.get<List>()) return list->size();
  if (const auto* text = value.get<std::string>()) return text->size();
  if (value.pose()) return 6;
  throw BadArgument{fmt::format("{} has no length", value.kind())};
}

double norm_of(const Arguments& a) {
  if (const auto number = a[0].number()) return std::abs(*number);
  double sum = 0.0;
  for (const double x : a.numbers(0, length_of(a[0]))) sum += x * x;
  return std::sqrt(sum);
}

Value extreme(const Arguments& a, bool largest) {
  const double x = a.real(0), y = a.real(1);
  return (x > y) == largest ? a[0] : a[1];
}

/// A list of lists of the same length.
Eigen::MatrixXd matrix_at(const Arguments& a, std::size_t i) {
  const List& rows = list_at(a, i);
  const auto* first = rows.empty() ? nullptr : rows[0].get<List>();
  if (first == nullptr || first->empty()) throw BadArgument{fmt::format("argument {} is not a matrix", i + 1)};
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(first->size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto row = rows[r].numbers(first->size());
    if (!row) throw BadArgument{fmt::format("row {} of the matrix is not of {} numbers", r, first->size())};
    for (std::size_t c = 0; c < row->size(); ++c)
      matrix(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = (*row)[c];
  }
  return matrix;
}

Value to_rows(const Eigen::MatrixXd& matrix) {
  List rows;
  for (const auto& row : matrix.rowwise()) rows.push_back(to_value(row));
  return rows;
}

Outcome inverse(const Arguments& a) {
  if (const auto pose = a[0].get<Pose>()) return Value(to_pose(to_isometry(*pose).inverse()));
  const Eigen::MatrixXd matrix = matrix_at(a, 0);
  if (matrix.rows() != matrix.cols()) throw BadArgument{"only a square matrix has an inverse"};
  const Eigen::FullPivLU<Eigen::MatrixXd> factors(matrix);
  if (!factors.isInvertible()) throw BadArgument{"the matrix is singular"};
  return to_rows(factors.inverse());
}

void add_lists(Library& library) {
  for (const char* signature : {"get_list_length(v)", "length(v)", "size(v)"})
    library.add(signature,
                checked([](const Arguments& a) -> Outcome { return Value(static_cast<int>(length_of(a[0]))); }));
  library.add("make_list(length, initial_value, capacity=0)", checked([](const Arguments& a) -> Outcome {
                return Value(List(static_cast<std::size_t>(a.integer(0, 0, kLongestMade)), a[1]));
              }));
  library.add("norm(a)", checked([](const Arguments& a) -> Outcome { return Value(norm_of(a)); }));
  library.add("normalize(v)", checked([](const Arguments& a) -> Outcome {
                const double norm = norm_of(a);
                auto numbers = a.numbers(0, list_at(a, 0).size());
                for (double& x : numbers) x = norm > 0.0 ? x / norm : 0.0;
                return to_list(numbers);
              }));
  library.add("integer_to_binary_list(x)", checked([](const Arguments& a) -> Outcome {
                const auto bits = static_cast<std::uint32_t>(a.integer(0));
                List list;
                for (int i = 0; i < 32; ++i) list.emplace_back((bits >> i & 1) != 0);
                return Value(std::move(list));
              }));
  library.add("binary_list_to_integer(l)", checked([](const Arguments& a) -> Outcome {
                std::uint32_t bits = 0;
                const List& list = list_at(a, 0);
                if (list.size() > 32) throw BadArgument{"a list of more than 32 bits"};
                for (std::size_t i = 0; i < list.size(); ++i)
                  if (list[i].truth().value_or(false)) bits |= std::uint32_t{1} << i;
                return Value(static_cast<std::int32_t>(bits));
              }));
}

void add_strings(Library& library) {
  library.add("to_str(value)", checked([](const Arguments& a) -> Outcome { return Value(a.text(0)); }));
  library.add("str_cat(a, b)", checked([](const Arguments& a) -> Outcome { return Value(a.text(0) + a.text(1)); }));
  library.add("str_len(s)",
              checked([](const Arguments& a) -> Outcome { return Value(static_cast<int>(a.text(0).size())); }));
  library.add("str_empty(s)", checked([](const Arguments& a) -> Outcome { return Value(a.text(0).empty()); }));
  library.add("str_at(s, index)", checked([](const Arguments& a) -> Outcome {
                const std::string text = a.text(0);
                const int at = a.integer(1, 0, static_cast<int>(text.size()) - 1);
                return Value(text.substr(static_cast<std::size_t>(at), 1));
              }));
  library.add("str_find(src, target, start_from=0)", checked([](const Arguments& a) -> Outcome {
                const std::size_t at = a.text(0).find(a.text(1), static_cast<std::size_t>(std::max(0, a.integer(2))));
                return Value(at == std::string::npos ? -1 : static_cast<int>(at));
              }));
  library.add("str_sub(src, index, len=-1)", checked([](const Arguments& a) -> Outcome {
                const std::string text = a.text(0);
                const int from = a.integer(1, 0, static_cast<int>(text.size())), length = a.integer(2);
                return Value(text.substr(static_cast<std::size_t>(from),
                                         length < 0 ? std::string::npos : static_cast<std::size_t>(length)));
              }));
  library.add("to_num(str)", checked([](const Arguments& a) -> Outcome {
                std::vector<Token> tokens;
                ScriptError error;
                const std::string text = a.text(0);
                const bool minus = text.starts_with('-');
                const bool read = tokenize(minus ? text.substr(1) : text, tokens, error);
                if (!read || tokens.size() != 2 || tokens[0].kind != Token::Kind::kNumber)
                  throw BadArgument{fmt::format("'{}' is not a number", text.substr(0, 40))};
                return minus ? *negated(tokens[0].value) : tokens[0].value;
              }));
}

}  // namespace

void add_math_functions(Library& library) {
  add_real(library, "sin(f)", std::sin);
  add_real(library, "cos(f)", std::cos);
  add_real(library, "tan(f)", std::tan);
  add_real(library, "asin(f)", std::asin);
  add_real(library, "acos(f)", std::acos);
  add_real(library, "atan(f)", std::atan);
  add_real(library, "sqrt(f)", std::sqrt);
  add_real(library, "d2r(d)", [](double x) { return x * (M_PI / 180.0); });
  add_real(library, "r2d(r)", [](double x) { return x * (180.0 / M_PI); });
  const auto add = [&](const char* signature, auto run) { library.add(signature, checked(run)); };
  add("floor(f)", [](const Arguments& a) -> Outcome { return Value(to_integer(std::floor(a.real(0)))); });
  add("ceil(f)", [](const Arguments& a) -> Outcome { return Value(to_integer(std::ceil(a.real(0)))); });
  add("abs(f)", [](const Arguments& a) -> Outcome { return a.real(0) < 0.0 ? *negated(a[0]) : a[0]; });
  add("atan2(x, y)", [](const Arguments& a) -> Outcome { return Value(std::atan2(a.real(0), a.real(1))); });
  add("pow(base, exponent)", [](const Arguments& a) -> Outcome {
    const double value = std::pow(a.real(0), a.real(1));
    if (!std::isfinite(value)) throw BadArgument{"no real number comes of it"};
    return Value(value);
  });
  add("log(b, f)", [](const Arguments& a) -> Outcome {
    const double value = std::log(a.real(1)) / std::log(a.real(0));
    if (!std::isfinite(value)) throw BadArgument{"no real number comes of it"};
    return Value(value);
  });
  add("max(a, b)", [](const Arguments& a) -> Outcome { return extreme(a, true); });
  add("min(a, b)", [](const Arguments& a) -> Outcome { return extreme(a, false); });
  add("transpose(m)", [](const Arguments& a) -> Outcome { return to_rows(matrix_at(a, 0).transpose()); });
  add("inv(m)", inverse);
  library.add("random()",
              [numbers = Random(1, "URScript")](const Call&) mutable -> Outcome { return Value(numbers.unit()); });
  add_lists(library);
  add_strings(library);
}

}  // namespace takt::languages::urscript
