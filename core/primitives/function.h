#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "core/net/primitive.h"
#include "core/net/setup.h"

namespace takt::primitives {

/// A port of a Function, in a row of a table: name, unit, documentation, frame.
struct Port {
  std::string_view name, unit, doc;
  std::string_view frame = {};
};

/// A number that a Function gets beside its inputs. With a fallback it may be left out.
struct Number {
  std::string_view name, unit, doc, range, example;
  std::optional<double> fallback = {};
};

template <std::size_t inputs, std::size_t outputs, std::size_t numbers>
struct Ports {
  std::array<Port, inputs> in;
  std::array<Port, outputs> out;
  std::array<Number, numbers> parameters;
};

/// ports({{input}...}, {{output}...}, {{parameter}...})
template <std::size_t inputs, std::size_t outputs>
constexpr Ports<inputs, outputs, 0> ports(const Port (&in)[inputs], const Port (&out)[outputs]) {
  return {std::to_array(in), std::to_array(out), {}};
}
template <std::size_t inputs, std::size_t outputs, std::size_t numbers>
constexpr Ports<inputs, outputs, numbers> ports(const Port (&in)[inputs], const Port (&out)[outputs],
                                                const Number (&parameters)[numbers]) {
  return {std::to_array(in), std::to_array(out), std::to_array(parameters)};
}

/// What a function gives, as a list of outputs: R, std::tuple<R...>, or an optional one of these.
template <class R>
struct Results {
  using Types = std::tuple<R>;
  static constexpr bool kMayBeNull = false;
};
template <class... R>
struct Results<std::tuple<R...>> {
  using Types = std::tuple<R...>;
  static constexpr bool kMayBeNull = false;
};
template <class R>
struct Results<std::optional<R>> : Results<R> {
  static constexpr bool kMayBeNull = true;
};

/// A primitive without state: outputs = function(inputs..., parameters...), all null if an input is null or the
/// function gives std::nullopt. `make_ports` gives the table of ports, and the types are those of the function:
///
///   using Add = Function<kAlike, [](double a, double b) { return a + b; }>;
///   TAKT_PRIMITIVE(Add, "arithmetic", "a + b.");
///
/// GCC 12 takes a bare '>' in such a lambda for the end of the arguments: put it in parentheses.
template <auto make_ports, auto function, class Signature = decltype(+function)>
class Function;

template <auto make_ports, auto function, class R, class... A>
class Function<make_ports, function, R (*)(A...)> final : public net::Primitive {
  static constexpr auto kPorts = make_ports();
  static constexpr std::size_t kInputs = kPorts.in.size(), kNumbers = kPorts.parameters.size();
  static_assert(kInputs + kNumbers == sizeof...(A), "an argument for each input and each parameter");

  using Arguments = std::tuple<std::remove_cvref_t<A>...>;
  using Values = typename Results<R>::Types;
  static_assert(kPorts.out.size() == std::tuple_size_v<Values>, "an output for each result");
  using InputIndex = std::make_index_sequence<kInputs>;
  using OutputIndex = std::make_index_sequence<std::tuple_size_v<Values>>;
  using NumberIndex = std::make_index_sequence<kNumbers>;

  template <std::size_t... i>
  static auto inputs(net::Setup& setup, std::index_sequence<i...>) {
    return std::tuple<net::In<std::tuple_element_t<i, Arguments>>...>{setup.in<std::tuple_element_t<i, Arguments>>(
        kPorts.in[i].name, {.unit = kPorts.in[i].unit, .frame = kPorts.in[i].frame, .doc = kPorts.in[i].doc})...};
  }
  template <std::size_t... i>
  static auto outputs(net::Setup& setup, std::index_sequence<i...>) {
    return std::tuple<net::Out<std::tuple_element_t<i, Values>>...>{
        setup.out<std::tuple_element_t<i, Values>>(kPorts.out[i].name, {.unit = kPorts.out[i].unit,
                                                                        .frame = kPorts.out[i].frame,
                                                                        .doc = kPorts.out[i].doc,
                                                                        .may_be_null = Results<R>::kMayBeNull})...};
  }
  static double number(net::Setup& setup, const Number& of) {
    const net::ParameterSpec spec{.unit = of.unit, .doc = of.doc, .range = of.range, .example = of.example};
    return of.fallback ? setup.parameter<net::Real>(of.name, *of.fallback, spec)
                       : setup.parameter<net::Real>(of.name, spec);
  }
  template <std::size_t... i>
  static std::array<double, kNumbers> numbers(net::Setup& setup, std::index_sequence<i...>) {
    return {number(setup, kPorts.parameters[i])...};
  }

 public:
  explicit Function(net::Setup& setup)
      : in_(inputs(setup, InputIndex{})),
        out_(outputs(setup, OutputIndex{})),
        numbers_(numbers(setup, NumberIndex{})) {}

  void update(const net::Cycle&) override { evaluate(InputIndex{}, NumberIndex{}); }

 private:
  template <std::size_t... i, std::size_t... n>
  void evaluate(std::index_sequence<i...>, std::index_sequence<n...>) {
    if ((std::get<i>(in_).null() || ...)) return set_null();
    set(function(*std::get<i>(in_)..., numbers_[n]...));
  }
  template <class Value>
  void set(const Value& value) {
    std::get<0>(out_).set(value);
  }
  template <class... Value>
  void set(const std::tuple<Value...>& values) {
    [&]<std::size_t... o>(std::index_sequence<o...>) { (std::get<o>(out_).set(std::get<o>(values)), ...); }
    (OutputIndex{});
  }
  template <class Value>
  void set(const std::optional<Value>& value) {
    if (!value) return set_null();
    set(*value);
  }
  void set_null() {
    std::apply([](auto&... out) { (out.set_null(), ...); }, out_);
  }

  decltype(inputs(std::declval<net::Setup&>(), InputIndex{})) in_;
  decltype(outputs(std::declval<net::Setup&>(), OutputIndex{})) out_;
  std::array<double, kNumbers> numbers_;
};

}  // namespace takt::primitives
