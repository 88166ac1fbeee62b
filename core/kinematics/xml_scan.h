#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"

namespace takt::kinematics {

/// An element of a scanned XML text; text between elements is not kept (URDF has none that matters).
struct XmlElement {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes;  ///< in the order of the file, entities resolved
  std::vector<int> children;                                    ///< indices into XmlTree::elements
  int line = 1;

  /// The attribute's value, or null.
  [[nodiscard]] const std::string* attribute(std::string_view key) const;
};

/// A flat tree: elements[0] is the root. `sanitized` is the text without byte-order mark and declarations, blanked in
/// place so that lines stay: what may be handed on to a parser that trusts its input.
struct XmlTree {
  std::vector<XmlElement> elements;
  std::string sanitized;

  /// Children of `element` with that name, in the order of the file.
  [[nodiscard]] std::vector<const XmlElement*> children(const XmlElement& element, std::string_view name) const;
};

/// Most elements above each other, and most attributes of one element: the XML library under urdfdom recurses per
/// level.
inline constexpr int kMaxXmlDepth = 64;
inline constexpr std::size_t kMaxXmlAttributes = 64;
inline constexpr std::size_t kMaxXmlBytes = 4u << 20;
inline constexpr std::size_t kMaxXmlElements = 100'000;

/// Scans without recursion what a URDF may hold of XML 1.0: elements, attributes, comments, CDATA, the predefined
/// entities. Everything else, and everything malformed, is one diagnostic with its line; there is no second one, since
/// after a broken tag nothing can be trusted. Realtime: setup.
[[nodiscard]] Result<XmlTree> scan_xml(std::string_view text);

}  // namespace takt::kinematics
