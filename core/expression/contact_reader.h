#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/expression/device_sensors.h"

namespace takt::expression {

/// A formula over contact wrenches for who reads it again and again: it is compiled anew only when something has
/// changed that it consists of (a bias, what is carried, where an arm stands). Thread: the one that steps the core,
/// between cycles. Realtime: setup.
template <class T>
class ContactReader {
 public:
  /// @param constants  of all its sensors, now   @param formula  makes it
  /// @return null: nothing
  [[nodiscard]] std::optional<T> now(std::vector<ContactConstants> constants,
                                     const std::function<Sensor<T>()>& formula) {
    if (!compiled_ || constants != constants_) {
      compiled_.emplace(formula().node());
      constants_ = std::move(constants);
    }
    return compiled_->now();
  }

 private:
  std::vector<ContactConstants> constants_;
  std::optional<CompiledFormula<T>> compiled_;
};

/// contact_wrench() of one sensor. The cell outlives it.
class ContactWrenchReader {
 public:
  ContactWrenchReader(const Cell& cell, std::string sensor) : cell_(&cell), sensor_(std::move(sensor)) {}

  /// Null, or no such sensor: nothing.
  [[nodiscard]] std::optional<net::Wrench> now(const Biases& biases) {
    return reader_.now({contact_constants(*cell_, sensor_, biases)},
                       [&] { return contact_wrench(*cell_, sensor_, biases); });
  }

 private:
  const Cell* cell_;
  std::string sensor_;
  ContactReader<net::Wrench> reader_;
};

/// Numbers of contacts that an expression of a program asks for in every cycle, by function and sensors.
using ContactReaders = std::map<std::string, ContactReader<net::Real>, std::less<>>;

}  // namespace takt::expression
