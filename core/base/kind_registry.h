#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/form.h"
#include "core/base/registration.h"

namespace takt {

/// All kinds of one sort of thing that files may name, in the order of their names: takt's own, and those of plug-ins.
/// @param Kind  has `name`, `form`, a static registry() and kWhat, what it is for people. Thread: the one that loads.
/// Realtime: setup.
template <class Kind>
class KindRegistry {
 public:
  explicit KindRegistry(std::vector<Kind> own) {
    for (Kind& kind : own) add(std::move(kind));
  }
  /// A name that is taken is a programming error (abort); plug-ins ask first.
  void add(Kind kind) {
    const auto place = std::ranges::lower_bound(kinds_, kind.name, {}, &Kind::name);
    if (place != kinds_.end() && place->name == kind.name) {
      std::fprintf(stderr, "takt: %s '%s' is registered twice\n", std::string(Kind::kWhat).c_str(), kind.name.c_str());
      std::abort();
    }
    kinds_.insert(place, std::move(kind));
  }
  /// Null if there is none.
  [[nodiscard]] const Kind* find(std::string_view name) const {
    const auto found = std::ranges::find(kinds_, name, &Kind::name);
    return found == kinds_.end() ? nullptr : &*found;
  }
  [[nodiscard]] const std::vector<Kind>& all() const { return kinds_; }
  [[nodiscard]] std::vector<NamedForm> forms() const {
    std::vector<NamedForm> forms;
    for (const Kind& kind : kinds_) forms.push_back({kind.name, kind.form});
    return forms;
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Kind& kind : kinds_) names.push_back(kind.name);
    return names;
  }

 private:
  std::vector<Kind> kinds_;
};

/// A kind of a plug-in, waiting for the loader.
template <class Kind>
class KindRegistration final : public Registration {
 public:
  KindRegistration(Registration*& list, Kind kind) : Registration(list), kind_(std::move(kind)), name_(kind_.name) {}

  [[nodiscard]] std::string_view what() const override { return Kind::kWhat; }
  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] Diagnostics check() const override {
    Diagnostics diagnostics;
    if (name_.empty()) diagnostics.error(Code::kMissing, "", fmt::format("{} without a name", Kind::kWhat));
    if (Kind::registry().find(name_) != nullptr)
      diagnostics.error(Code::kDuplicate, "", fmt::format("{} '{}' is registered already", Kind::kWhat, name_),
                        "Choose another name");
    return diagnostics;
  }
  void add() override { Kind::registry().add(std::move(kind_)); }

 private:
  Kind kind_;
  std::string name_;
};

}  // namespace takt
