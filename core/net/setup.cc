#include "core/net/setup.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/setup_impl.h"
#include "core/net/value_json.h"

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

const Json kNoJson;

template <class T>
std::string type_name() {
  if constexpr (std::is_same_v<T, std::string>) {
    return "String";
  } else {
    return std::string(name_of(kValueType<T>));
  }
}

template <class T>
T placeholder() {
  if constexpr (std::is_same_v<T, std::string>) {
    return {};
  } else {
    return null_payload<T>();
  }
}

std::string missing_hint(std::string_view type, const ParameterSpec& spec) {
  return fmt::format("{}{}{}{}", type, spec.unit.empty() ? "" : fmt::format(" in {}", spec.unit),
                     spec.range.empty() ? "" : fmt::format(", {}", spec.range),
                     spec.doc.empty() ? "" : fmt::format(": {}", spec.doc));
}

void missing(Diagnostics& diagnostics, std::string_view name, std::string_view type, const ParameterSpec& spec) {
  diagnostics.error(Code::kMissing, {}, fmt::format("parameter '{}' is missing", name), missing_hint(type, spec));
}

/// Reads and checks a parameter that is given; on an error `value` stays.
template <class T>
void read_parameter(const Json& json, std::string_view name, const ParameterSpec& spec, T& value,
                    Diagnostics& diagnostics) {
  T read = placeholder<T>();
  Diagnostics found = value_from_json(json, read);
  if (found.empty()) found = check_range(read, spec.range);
  if (found.empty()) {
    value = read;
  } else {
    diagnostics.append(found, pointer_segment(name));
  }
}

}  // namespace

void programming_error(const std::string& message) {
  std::fprintf(stderr, "takt: %s\n", message.c_str());
  std::abort();
}

std::size_t Setup::Impl::port_index(const std::vector<PrimitiveInfo::Port>& ports, std::size_t& next,
                                    std::string_view name, ValueType type) {
  std::size_t index = next++;
  if (index >= ports.size() || ports[index].name != name) {
    const auto found = std::ranges::find(ports, name, &PrimitiveInfo::Port::name);
    index = static_cast<std::size_t>(found - ports.begin());
  }
  if (index >= ports.size() || ports[index].type != type) {
    programming_error(fmt::format("primitive {} declares port '{}' only in some instances", info->type, name));
  }
  return index;
}

const Json* Setup::Impl::given(std::string_view name) const {
  const auto found = parameters->find(name);
  return found == parameters->end() ? nullptr : &*found;
}

const Json* Setup::Impl::declared_null(std::string_view name) const {
  if (on_null == nullptr || !on_null->is_object()) return nullptr;
  const auto found = on_null->find(name);
  return found == on_null->end() ? nullptr : &*found;
}

void Setup::Impl::describe_parameter(std::string_view name, std::string type, const ParameterSpec& spec,
                                     std::string fallback) {
  describing->parameters.push_back({std::string(name), std::move(type), spec, std::move(fallback)});
}

void Setup::exclusive(std::initializer_list<std::string_view> outputs) {
  if (describing()) impl_.describing->exclusive_outputs.emplace_back(outputs.begin(), outputs.end());
}

void Setup::means(std::string_view output, std::string_view formula) {
  if (describing()) impl_.describing->meanings.push_back({std::string(output), std::string(formula)});
}

void Setup::is_merge() {
  if (describing()) impl_.describing->merge = true;
}

const std::string& Setup::id() const {
  static const std::string kNone;
  return impl_.id == nullptr ? kNone : *impl_.id;
}

bool Setup::describing() const { return impl_.describing != nullptr; }

template <class T>
In<T> Setup::in(std::string_view name, const PortSpec& spec) {
  if (describing()) {
    impl_.describing->inputs.push_back({std::string(name), kValueType<T>, spec});
    return In<T>();
  }
  const std::size_t index = impl_.port_index(impl_.info->inputs, impl_.next_input, name, kValueType<T>);
  return In<T>(static_cast<const Slot<T>*>(impl_.inputs[index]));
}

template <class T>
Out<T> Setup::out(std::string_view name, const PortSpec& spec) {
  if (describing()) {
    impl_.describing->outputs.push_back({std::string(name), kValueType<T>, spec});
    return Out<T>();
  }
  const std::size_t index = impl_.port_index(impl_.info->outputs, impl_.next_output, name, kValueType<T>);
  return Out<T>(static_cast<Slot<T>*>(impl_.outputs[index]));
}

Flag Setup::flag(std::string_view name, const PortSpec& spec) {
  const In<Boolean> input = in<Boolean>(name, spec);
  bool counts_as = spec.on_null == OnNull::kCountsAsTrue;
  if (describing()) {
    impl_.describing->flags.emplace_back(name);
  } else if (const Json* declared = impl_.declared_null(name); declared != nullptr && declared->is_boolean()) {
    counts_as = declared->get<bool>();
  }
  return {input, counts_as};
}

Integer Setup::bridge_cycles(std::string_view name) {
  if (describing()) {
    impl_.describing->bridgeable_inputs.emplace_back(name);
    return 0;
  }
  const Json* declared = impl_.declared_null(name);
  if (declared == nullptr || !declared->is_object()) return 0;
  return declared->value("bridge_cycles", Integer{0});
}

template <class T>
T Setup::parameter(std::string_view name, const ParameterSpec& spec) {
  T value = placeholder<T>();
  if (describing()) {
    impl_.describe_parameter(name, type_name<T>(), spec, {});
  } else if (const Json* json = impl_.given(name)) {
    read_parameter(*json, name, spec, value, impl_.diagnostics);
  } else {
    missing(impl_.diagnostics, name, type_name<T>(), spec);
  }
  return value;
}

template <class T>
T Setup::parameter(std::string_view name, const T& fallback, const ParameterSpec& spec) {
  T value = fallback;
  if (describing()) {
    impl_.describe_parameter(name, type_name<T>(), spec, value_to_json(fallback).dump());
  } else if (const Json* json = impl_.given(name)) {
    read_parameter(*json, name, spec, value, impl_.diagnostics);
  }
  return value;
}

const Json& Setup::json(std::string_view name, const ParameterSpec& spec) {
  if (describing()) {
    impl_.describe_parameter(name, "json", spec, {});
  } else if (const Json* json = impl_.given(name)) {
    return *json;
  } else {
    missing(impl_.diagnostics, name, "JSON", spec);
  }
  return kNoJson;
}

const Json* Setup::optional_json(std::string_view name, const ParameterSpec& spec) {
  if (!describing()) return impl_.given(name);
  impl_.describe_parameter(name, "json", spec, "null");
  return nullptr;
}

Resource* Setup::resource(std::string_view name, std::string_view kind, std::string_view doc) {
  const ParameterSpec spec{.doc = doc};
  if (describing()) {
    impl_.describe_parameter(name, fmt::format("device:{}", kind), spec, {});
    return nullptr;
  }
  const auto text = parameter<std::string>(name, spec);
  if (text.empty()) return nullptr;  // missing or no text: that is a diagnostic already
  Resource* found = impl_.environment->find(text);
  if (found != nullptr && (kind.empty() || found->kind() == kind)) return found;
  std::vector<std::string> choices;
  for (std::string& other : impl_.environment->names()) {
    const Resource* resource = impl_.environment->find(other);
    if (resource != nullptr && (kind.empty() || resource->kind() == kind)) choices.push_back(std::move(other));
  }
  const std::string shown = text.substr(0, 64);
  impl_.diagnostics.error(
      Code::kUnknownName, pointer_segment(name),
      found == nullptr ? fmt::format("there is no device '{}'", shown)
                       : fmt::format("'{}' is of kind {}, not {}", shown, found->kind(), kind),
      choices.empty() ? fmt::format("no device of kind '{}' is there", kind) : nearest_choice(shown, choices));
  return nullptr;
}

void Setup::claims(std::string_view name, std::string_view state) {
  if (describing()) {
    impl_.describing->claims = name;
    return;
  }
  const Json* json = impl_.given(name);
  if (json == nullptr || !json->is_string()) return;
  Resource* claimed = impl_.environment->find(json->get_ref<const std::string&>());
  if (claimed == nullptr) return;
  impl_.claims.push_back(claimed);
  impl_.claim_states.push_back({claimed, std::string(state)});
}

void Setup::latency(std::string_view in, std::string_view out, Latency latency) {
  if (describing()) impl_.describing->latencies.push_back({std::string(in), std::string(out), latency});
}

void Setup::latency_by(std::string_view in, std::string_view out, std::string_view cycles_parameter) {
  if (describing())
    impl_.describing->latencies.push_back({std::string(in), std::string(out), {}, std::string(cycles_parameter)});
}

void Setup::breaks_loop(std::string_view in) {
  if (describing()) impl_.describing->loop_breaking_inputs.emplace_back(in);
}

void Setup::is_termination() {
  if (describing()) impl_.describing->termination = true;
}

void Setup::is_cancel(std::string_view bound) {
  if (describing()) impl_.describing->cancel_bound = bound;
}

void Setup::costs(double ns) {
  if (describing()) impl_.describing->cost_ns = ns;
}

void Setup::is_source() {
  if (describing()) impl_.describing->source = true;
}

void Setup::is_monitor() {
  if (describing()) impl_.describing->monitor = true;
}

#define TAKT_PORT(T)                                              \
  template In<T> Setup::in<T>(std::string_view, const PortSpec&); \
  template Out<T> Setup::out<T>(std::string_view, const PortSpec&);
#define TAKT_PARAMETER(T)                                                 \
  template T Setup::parameter<T>(std::string_view, const ParameterSpec&); \
  template T Setup::parameter<T>(std::string_view, const T&, const ParameterSpec&);
#define TAKT_VALUE(T) TAKT_PORT(T) TAKT_PARAMETER(T)
TAKT_VALUE(Boolean)
TAKT_VALUE(Integer)
TAKT_VALUE(Real)
TAKT_VALUE(Text)
TAKT_VALUE(Vector)
TAKT_VALUE(Rotation)
TAKT_VALUE(Frame)
TAKT_VALUE(Twist)
TAKT_VALUE(Wrench)
TAKT_VALUE(JointArray)
TAKT_PARAMETER(std::string)
#undef TAKT_VALUE
#undef TAKT_PARAMETER
#undef TAKT_PORT

}  // namespace takt::net
