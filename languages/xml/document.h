#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/text_location.h"

namespace takt::languages {

/// An attribute of an element, with where its value is written.
struct XmlAttribute {
  std::string space;  ///< URI of its namespace; empty: none
  std::string name, value;
  TextLocation at;
};

/// An element with what is in it, in the order of the file.
struct XmlElement {
  /// An element or a text.
  struct Child {
    std::unique_ptr<XmlElement> element;
    std::string text;
  };
  std::string space, name;
  std::vector<XmlAttribute> attributes;
  std::vector<Child> children;
  TextLocation at;

  [[nodiscard]] const XmlAttribute* find(std::string_view attribute, std::string_view of_space = {}) const;
  /// The texts in it, joined; those of elements in it are left out.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] bool has_elements() const;
  /// The element as XML, with the namespaces that it needs. @param around  namespace that is in force around it
  [[nodiscard]] std::string to_xml(std::string_view around = {}) const;
  /// What is in it as XML.
  [[nodiscard]] std::string inner_xml() const;
};

/// What an XML document may be at most.
struct XmlLimits {
  std::size_t bytes = 1u << 20, depth = 48, elements = 20'000, attributes = 64;
};

/// A document (XML 1.0 with namespaces). A DOCTYPE is refused: with it go entities of the document's own, which can
/// grow without end, and those that are read from elsewhere. Diagnostics have line and column, no file. Realtime:
/// setup.
[[nodiscard]] Result<std::unique_ptr<XmlElement>> parse_xml(std::string_view text, const XmlLimits& limits = {});

/// An error at a location of the document.
void error_at(const TextLocation& at, Code code, std::string message, std::string hint, Diagnostics& diagnostics);
/// A warning there.
void warning_at(const TextLocation& at, Code code, std::string message, std::string hint, Diagnostics& diagnostics);

}  // namespace takt::languages
