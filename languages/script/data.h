#pragma once

#include <string>

namespace takt::languages {

/// A value outside of a script: of an event, a parameter, a constant. Values go from one machine to another as data and
/// never as references.
struct Data {
  enum class Kind { kUndefined, kJson, kXml };
  Kind kind = Kind::kUndefined;
  std::string text;  ///< JSON or XML
  bool operator==(const Data&) const = default;

  static Data of_json(std::string json) { return {Kind::kJson, std::move(json)}; }
  static Data of_xml(std::string xml) { return {Kind::kXml, std::move(xml)}; }
};

}  // namespace takt::languages
