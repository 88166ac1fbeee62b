#include "core/net/registry.h"

#include <algorithm>
#include <exception>
#include <mutex>

#include <fmt/format.h>

#include "core/net/formula.h"
#include "core/net/frame_check.h"
#include "core/net/setup_impl.h"
#include "core/net/unit.h"

namespace takt::net {

struct Registry::Entry {
  std::string name;
  Maker maker;
  mutable PrimitiveInfo info;
  /// A mutex and not a std::once_flag: a constructor may throw in its first description, and waiters of a once_flag may
  /// then wait for ever (libstdc++ over an intercepted pthread_once).
  mutable std::mutex describing;
  mutable bool described = false;
};

namespace {

bool duplicate_name(const PrimitiveInfo& info) {
  std::vector<std::string> inputs;
  for (const auto& port : info.inputs) inputs.push_back(port.name);
  for (const auto& parameter : info.parameters) inputs.push_back(parameter.name);
  std::vector<std::string> outputs;
  for (const auto& port : info.outputs) outputs.push_back(port.name);
  const auto twice = [](std::vector<std::string>& names) {
    std::ranges::sort(names);
    return std::ranges::adjacent_find(names) != names.end();
  };
  return twice(inputs) || twice(outputs);
}

/// Unit and frame texts are part of the program: a malformed one is found at the first look at its type.
void check_texts(const PrimitiveInfo& info, Diagnostics& diagnostics) {
  for (const auto* ports : {&info.inputs, &info.outputs}) {
    for (const PrimitiveInfo::Port& port : *ports) {
      if (!parse_unit(port.spec.unit)) {
        diagnostics.error(Code::kInvalidName, {},
                          fmt::format("{}.{}: '{}' is not a unit", info.type, port.name, port.spec.unit));
      }
      if (!parse_frame_names(port.spec.frame, info)) {
        diagnostics.error(Code::kInvalidName, {},
                          fmt::format("{}.{}: '{}' names no frames", info.type, port.name, port.spec.frame));
      }
    }
  }
}

/// So is what a type says of the meaning of its outputs.
void check_declarations(const PrimitiveInfo& info, Diagnostics& diagnostics) {
  const auto boolean_output = [&](const std::string& name) {
    return std::ranges::any_of(info.outputs, [&](const PrimitiveInfo::Port& port) {
      return port.name == name && port.type == ValueType::kBoolean;
    });
  };
  for (const PrimitiveInfo::Meaning& meaning : info.meanings) {
    if (!boolean_output(meaning.output) || !parse_formula(meaning.formula, info)) {
      diagnostics.error(Code::kSyntax, {},
                        fmt::format("{}.{}: '{}' is not a formula", info.type, meaning.output, meaning.formula));
    }
  }
  for (const auto& group : info.exclusive_outputs) {
    if (!std::ranges::all_of(group, boolean_output)) {
      diagnostics.error(Code::kRequires, {}, fmt::format("{}: exclusive outputs are Boolean", info.type));
    }
  }
  const bool one_type = std::ranges::all_of(
      info.inputs, [&](const auto& in) { return !info.outputs.empty() && in.type == info.outputs.front().type; });
  if (info.merge && (info.outputs.size() != 1 || info.inputs.size() < 2 || !one_type)) {
    diagnostics.error(Code::kRequires, {}, fmt::format("{}: a merge has inputs and one output of one type", info.type));
  }
}

/// Runs the constructor once without a net, so that it declares ports and parameters. @return what is wrong with them.
Diagnostics describe(const Maker& maker, PrimitiveInfo& info) {
  Diagnostics diagnostics;
  Setup::Impl impl;
  impl.describing = &info;
  Setup setup(impl);
  const std::align_val_t alignment{maker.alignment};
  const auto release = [&](void* place) { ::operator delete(place, maker.size, alignment); };
  const std::unique_ptr<void, decltype(release)> place(::operator new(maker.size, alignment), release);
  try {
    maker.construct(place.get(), setup)->~Primitive();
  } catch (const std::exception& error) {
    diagnostics.error(Code::kInternal, {}, fmt::format("describing primitive {} threw: {}", info.type, error.what()));
  }
  if (duplicate_name(info)) {
    diagnostics.error(Code::kDuplicate, {},
                      fmt::format("primitive {} uses one name for two ports or parameters", info.type));
  }
  check_texts(info, diagnostics);
  check_declarations(info, diagnostics);
  const bool has_device = std::ranges::any_of(
      info.parameters, [](const PrimitiveInfo::Parameter& p) { return p.type.starts_with("device:"); });
  info.source = info.source || (has_device && !info.outputs.empty());
  return diagnostics;
}

}  // namespace

Registry::Registry() = default;
Registry::~Registry() = default;

Registry& Registry::global() {
  static Registry registry;
  return registry;
}

bool Registry::add(std::string_view type, std::string_view family, std::string_view doc, Maker maker) {
  const auto place =
      std::ranges::lower_bound(entries_, type, {}, [](const auto& e) { return std::string_view(e->name); });
  if (place != entries_.end() && (*place)->name == type) {
    programming_error(fmt::format("primitive {} is registered twice", type));
  }
  auto entry = std::make_unique<Entry>();
  entry->name = type;
  entry->maker = maker;
  entry->info.type = type;
  entry->info.family = family;
  entry->info.doc = doc;
  entries_.insert(place, std::move(entry));
  return true;
}

bool Registry::means(std::string_view type, std::string_view output, std::string_view formula) {
  const Entry* found = entry(type);
  if (found == nullptr) programming_error(fmt::format("a meaning of {}, which is not registered", type));
  found->info.meanings.push_back({std::string(output), std::string(formula)});
  return true;
}

const Registry::Entry* Registry::entry(std::string_view type) const {
  const auto place =
      std::ranges::lower_bound(entries_, type, {}, [](const auto& e) { return std::string_view(e->name); });
  return place != entries_.end() && (*place)->name == type ? place->get() : nullptr;
}

const PrimitiveInfo* Registry::find(std::string_view type) const {
  const Entry* found = entry(type);
  if (found == nullptr) return nullptr;
  const std::lock_guard lock(found->describing);
  if (!found->described) {
    PrimitiveInfo info = found->info;  // what a constructor has declared before it throws is not kept
    const Diagnostics wrong = describe(found->maker, info);
    if (wrong.has_errors()) programming_error(wrong.list().front().message);
    found->info = std::move(info);
    found->described = true;
  }
  return &found->info;
}

const Maker* Registry::maker(std::string_view type) const {
  const Entry* found = entry(type);
  return found == nullptr ? nullptr : &found->maker;
}

std::vector<const PrimitiveInfo*> Registry::all() const {
  std::vector<const PrimitiveInfo*> infos;
  for (const auto& e : entries_) infos.push_back(find(e->name));
  return infos;
}

std::vector<std::string> Registry::names() const {
  std::vector<std::string> names;
  for (const auto& e : entries_) names.push_back(e->name);
  return names;
}

Diagnostics Registry::check(std::string_view type, const Maker& maker) const {
  Diagnostics diagnostics;
  if (const Entry* taken = entry(type)) {
    diagnostics.error(Code::kDuplicate, {},
                      fmt::format("primitive '{}' is registered already, in family '{}'", type, taken->info.family),
                      "Choose another name");
    return diagnostics;
  }
  PrimitiveInfo info;
  info.type = type;
  return describe(maker, info);
}

}  // namespace takt::net
