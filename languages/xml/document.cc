#include "languages/xml/document.h"

#include <algorithm>

#include <expat.h>
#include <fmt/format.h>

#include "core/base/xml_text.h"

namespace takt::languages {
namespace {

/// Between namespace and name: no character of a URI.
constexpr char kSeparator = '\n';

void split(std::string_view whole, std::string& space, std::string& name) {
  const auto at = whole.rfind(kSeparator);
  space = at == std::string_view::npos ? "" : std::string(whole.substr(0, at));
  name = std::string(at == std::string_view::npos ? whole : whole.substr(at + 1));
}

/// Builds the tree while expat reads.
struct Builder {
  std::string_view source;
  const XmlLimits& limits;
  XML_Parser parser;
  Diagnostics diagnostics = {};
  std::unique_ptr<XmlElement> root = nullptr;
  std::vector<XmlElement*> open = {};
  std::size_t elements = 0;

  [[nodiscard]] TextLocation here() const {
    return {static_cast<int>(XML_GetCurrentLineNumber(parser)),
            static_cast<int>(XML_GetCurrentColumnNumber(parser)) + 1};
  }
  void refuse(Code code, std::string message, std::string hint) {
    error_at(here(), code, std::move(message), std::move(hint), diagnostics);
    XML_StopParser(parser, XML_FALSE);
  }

  void begin(const char* whole, const char** attributes) {
    if (open.size() >= limits.depth)
      return refuse(Code::kTooLarge, fmt::format("elements are nested more than {} deep", limits.depth),
                    "Nest them less");
    if (++elements > limits.elements)
      return refuse(Code::kTooLarge, fmt::format("more than {} elements", limits.elements), "Split the document");
    auto element = std::make_unique<XmlElement>();
    split(whole, element->space, element->name);
    element->at = here();
    for (; *attributes != nullptr; attributes += 2) {
      XmlAttribute one;
      split(attributes[0], one.space, one.name);
      one.value = attributes[1];
      element->attributes.push_back(std::move(one));
    }
    if (element->attributes.size() > limits.attributes)
      return refuse(Code::kTooLarge, fmt::format("{} attributes", element->attributes.size()),
                    fmt::format("Give {} at most", limits.attributes));
    locate_attributes(*element);
    XmlElement* const raw = element.get();
    if (open.empty()) {
      root = std::move(element);
    } else {
      open.back()->children.push_back({std::move(element), {}});
    }
    open.push_back(raw);
  }

  /// Walks over the tag in the source. Of a document in another encoding than UTF-8 they have the element's location.
  void locate_attributes(XmlElement& element) const {
    for (XmlAttribute& one : element.attributes) one.at = element.at;
    const auto start = XML_GetCurrentByteIndex(parser);
    if (start < 0 || static_cast<std::size_t>(start) >= source.size()) return;
    TextLocation at = element.at;
    std::string word;
    char quote = 0;
    for (std::size_t i = static_cast<std::size_t>(start); i < source.size(); ++i) {
      const char c = source[i];
      if (c == '\n') ++at.line, at.column = 0;
      ++at.column;
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
        note_value(element, word, at);
        word.clear();
      } else if (c == '>') {
        return;
      } else if (c == ' ' || c == '\t' || c == '\n' || c == '\r') {
        if (i + 1 < source.size() && source[i + 1] != '=') word.clear();
      } else if (c != '=') {
        word += c;
      }
    }
  }
  static void note_value(XmlElement& element, std::string_view word, const TextLocation& at) {
    const auto colon = word.find(':');
    const std::string_view local = colon == std::string_view::npos ? word : word.substr(colon + 1);
    for (XmlAttribute& one : element.attributes) {
      if (one.name == local && one.space.empty() == (colon == std::string_view::npos)) one.at = at;
    }
  }

  void text(std::string_view piece) {
    if (open.empty()) return;
    auto& children = open.back()->children;
    if (children.empty() || children.back().element) children.push_back({nullptr, {}});
    children.back().text += piece;
  }
};

void on_begin(void* builder, const XML_Char* name, const XML_Char** attributes) {
  static_cast<Builder*>(builder)->begin(name, attributes);
}
void on_end(void* builder, const XML_Char*) { static_cast<Builder*>(builder)->open.pop_back(); }
void on_text(void* builder, const XML_Char* text, int length) {
  static_cast<Builder*>(builder)->text({text, static_cast<std::size_t>(length)});
}
void on_doctype(void* builder, const XML_Char* name, const XML_Char*, const XML_Char*, int) {
  static_cast<Builder*>(builder)->refuse(Code::kUnsupported, fmt::format("a document type '{}'", name),
                                         "Remove <!DOCTYPE ...> and the entities in it");
}

}  // namespace

const XmlAttribute* XmlElement::find(std::string_view attribute, std::string_view of_space) const {
  const auto found = std::ranges::find_if(
      attributes, [&](const XmlAttribute& one) { return one.name == attribute && one.space == of_space; });
  return found == attributes.end() ? nullptr : &*found;
}

std::string XmlElement::text() const {
  std::string joined;
  for (const Child& child : children) joined += child.text;
  return joined;
}

bool XmlElement::has_elements() const {
  return std::ranges::any_of(children, [](const Child& child) { return child.element != nullptr; });
}

std::string XmlElement::to_xml(std::string_view around) const {
  std::string xml = "<" + name;
  if (space != around) xml += fmt::format(" xmlns=\"{}\"", xml_text(space));
  int number = 0;
  for (const XmlAttribute& one : attributes) {
    std::string prefix;
    if (!one.space.empty()) {
      prefix = fmt::format("n{}:", ++number);
      xml += fmt::format(" xmlns:n{}=\"{}\"", number, xml_text(one.space));
    }
    xml += fmt::format(" {}{}=\"{}\"", prefix, one.name, xml_text(one.value));
  }
  if (children.empty()) return xml + "/>";
  xml += ">";
  for (const Child& child : children) xml += child.element ? child.element->to_xml(space) : xml_text(child.text);
  return xml + "</" + name + ">";
}

std::string XmlElement::inner_xml() const {
  std::string xml;
  for (const Child& child : children) xml += child.element ? child.element->to_xml() : xml_text(child.text);
  return xml;
}

Result<std::unique_ptr<XmlElement>> parse_xml(std::string_view text, const XmlLimits& limits) {
  if (text.size() > limits.bytes)
    return failure(Code::kTooLarge, {}, fmt::format("a document of {} bytes", text.size()),
                   fmt::format("Give {} at most", limits.bytes));
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser(
      XML_ParserCreateNS(nullptr, kSeparator), &XML_ParserFree);
  Builder builder{.source = text, .limits = limits, .parser = parser.get()};
  XML_SetUserData(parser.get(), &builder);
  XML_SetElementHandler(parser.get(), on_begin, on_end);
  XML_SetCharacterDataHandler(parser.get(), on_text);
  XML_SetStartDoctypeDeclHandler(parser.get(), on_doctype);
  const XML_Status status = XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const bool json = first != std::string_view::npos && (text[first] == '{' || text[first] == '[');
  if (status != XML_STATUS_OK && json) {
    builder.refuse(Code::kSyntax, "this is JSON, not XML",
                   "Give the XML file itself; a scenario that names one is run by takt run");
  } else if (status != XML_STATUS_OK && !builder.diagnostics.has_errors()) {
    builder.refuse(Code::kSyntax,
                   fmt::format("not well-formed XML: {}", XML_ErrorString(XML_GetErrorCode(parser.get()))),
                   "Correct the document there");
  }
  if (builder.diagnostics.has_errors()) return std::unexpected(std::move(builder.diagnostics));
  return std::move(builder.root);
}

void error_at(const TextLocation& at, Code code, std::string message, std::string hint, Diagnostics& diagnostics) {
  diagnostics.error(code, {}, std::move(message), std::move(hint));
  diagnostics.list().back().line = at.line;
  diagnostics.list().back().column = at.column;
}

void warning_at(const TextLocation& at, Code code, std::string message, std::string hint, Diagnostics& diagnostics) {
  diagnostics.warning(code, {}, std::move(message), std::move(hint));
  diagnostics.list().back().line = at.line;
  diagnostics.list().back().column = at.column;
}

}  // namespace takt::languages
