#include "core/kinematics/xml_scan.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>

#include <fmt/format.h>

namespace takt::kinematics {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

bool is_name_start(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == ':' ||
         (static_cast<unsigned char>(c) >= 0x80);
}

bool is_name(char c) { return is_name_start(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; }

/// Length of the valid UTF-8 sequence at the start of `text`, 0 if there is none (or it is a control character).
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= 0x20 || is_space(text[0]) ? 1 : 0;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  std::uint32_t code = first & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3F);
  }
  constexpr std::array<std::uint32_t, 5> kSmallest = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  // U+FEFF and the two non-characters get special treatment in the library under urdfdom; nobody needs them.
  const bool special = code == 0xFEFF || code == 0xFFFE || code == 0xFFFF;
  return code < kSmallest[length] || code > 0x10FFFF || surrogate || special ? 0 : length;
}

/// A scanner with one position; every function leaves a diagnostic and returns false when it cannot go on.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text), sanitized_(text) {}

  Result<XmlTree> run() {
    if (!check_bytes() || !scan_all()) return std::unexpected(std::move(diagnostics_));
    return XmlTree{std::move(elements_), std::move(sanitized_)};
  }

 private:
  bool fail(std::string message, std::string hint = {}) {
    diagnostics_.error(Code::kSyntax, fmt::format("line {}", line_), std::move(message), std::move(hint));
    return false;
  }

  bool check_bytes() {
    if (text_.size() > kMaxXmlBytes)
      return fail(fmt::format("the file has {} bytes", text_.size()), fmt::format("at most {}", kMaxXmlBytes));
    if (text_.starts_with("\xEF\xBB\xBF")) {
      std::fill_n(sanitized_.begin(), 3, ' ');
      at_ = 3;
    }
    std::size_t i = at_;
    while (i < text_.size()) {
      const std::size_t length = utf8_length(text_.substr(i));
      if (length == 0)
        return fail(fmt::format("byte 0x{:02x} is not text", static_cast<unsigned char>(text_[i])), "UTF-8");
      if (text_[i] == '\n') ++line_;
      i += length;
    }
    line_ = 1;
    return true;
  }

  bool scan_all() {
    while (at_ < text_.size()) {
      if (text_[at_] == '<' ? !scan_markup() : !scan_text()) return false;
    }
    if (!open_.empty()) {
      const XmlElement& last = elements_[static_cast<std::size_t>(open_.back())];
      return fail(fmt::format("the file ends inside <{}> of line {}", last.name, last.line), "is it truncated?");
    }
    return elements_.empty() ? fail("no XML element", "a URDF is XML with the root <robot>") : true;
  }

  bool scan_text() {
    const char c = text_[at_];
    if (open_.empty() && !is_space(c)) return fail("text outside of the root element");
    if (c == '&' && !skip_entity()) return false;
    advance(1);
    return true;
  }

  bool skip_entity() {
    std::string ignored;
    std::size_t used = 0;
    return resolve_entity(text_.substr(at_), ignored, used);
  }

  bool scan_markup() {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("<!--")) return skip("<!--", "-->", "comment", false);
    if (rest.starts_with("<![CDATA[")) return skip("<![CDATA[", "]]>", "CDATA section", false);
    if (rest.starts_with("<!")) return fail("a DOCTYPE or entity declaration", "a URDF needs none; it is not allowed");
    if (rest.starts_with("<?")) return check_declaration(rest) && skip("<?", "?>", "declaration", true);
    if (rest.starts_with("</")) return scan_end_tag();
    return scan_start_tag();
  }

  bool check_declaration(std::string_view rest) {
    std::string text(rest.substr(0, rest.find("?>")));
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool foreign = text.find("encoding") != std::string::npos && text.find("utf-8") == std::string::npos &&
                         text.find("ascii") == std::string::npos;
    return foreign ? fail("an encoding other than UTF-8") : true;
  }

  bool skip(std::string_view begin, std::string_view end, std::string_view what, bool blank) {
    const std::size_t found = text_.find(end, at_ + begin.size());
    if (found == std::string_view::npos) return fail(fmt::format("a {} without end", what), "is the file truncated?");
    if (open_.empty() && begin == "<![CDATA[") return fail("text outside of the root element");
    const std::size_t length = found + end.size() - at_;
    if (blank) {
      for (std::size_t i = at_; i < at_ + length; ++i) {
        if (text_[i] != '\n') sanitized_[i] = ' ';
      }
    }
    advance(length);
    return true;
  }

  bool scan_end_tag() {
    advance(2);
    const std::string name = scan_name();
    skip_space();
    if (open_.empty()) return fail(fmt::format("</{}> closes nothing", name));
    const XmlElement& last = elements_[static_cast<std::size_t>(open_.back())];
    if (name != last.name) return fail(fmt::format("</{}> closes <{}> of line {}", name, last.name, last.line));
    if (!take('>')) return fail(fmt::format("'>' is missing after </{}", name));
    open_.pop_back();
    return true;
  }

  bool scan_start_tag() {
    const int line = line_;
    advance(1);
    XmlElement element{scan_name(), {}, {}, line};
    if (element.name.empty()) return fail("'<' without the name of an element", "write &lt; for the character itself");
    if (open_.empty() && !elements_.empty()) return fail(fmt::format("a second root element <{}>", element.name));
    if (open_.size() >= kMaxXmlDepth)
      return fail(fmt::format("<{}> lies deeper than {} elements", element.name, kMaxXmlDepth));
    while (true) {
      const bool spaced = skip_space();
      if (at_ >= text_.size())
        return fail(fmt::format("the file ends inside the tag <{}", element.name), "is it truncated?");
      if (take('>')) return push(std::move(element), true);
      if (text_.substr(at_).starts_with("/>")) {
        advance(2);
        return push(std::move(element), false);
      }
      if (!spaced) return fail(fmt::format("unexpected '{}' in the tag <{}", text_[at_], element.name));
      if (!scan_attribute(element)) return false;
    }
  }

  bool push(XmlElement element, bool opens) {
    if (elements_.size() >= kMaxXmlElements) return fail(fmt::format("more than {} elements", kMaxXmlElements));
    const int index = static_cast<int>(elements_.size());
    if (!open_.empty()) elements_[static_cast<std::size_t>(open_.back())].children.push_back(index);
    elements_.push_back(std::move(element));
    if (opens) open_.push_back(index);
    return true;
  }

  bool scan_attribute(XmlElement& element) {
    const std::string key = scan_name();
    if (key.empty()) return fail(fmt::format("unexpected '{}' in the tag <{}", text_[at_], element.name));
    if (element.attribute(key)) return fail(fmt::format("duplicate attribute '{}' in <{}>", key, element.name));
    if (element.attributes.size() >= kMaxXmlAttributes)
      return fail(fmt::format("<{}> has more than {} attributes", element.name, kMaxXmlAttributes));
    skip_space();
    if (!take('=')) return fail(fmt::format("attribute '{}' of <{}> has no value", key, element.name));
    skip_space();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '"' && quote != '\'') return fail(fmt::format("the value of '{}' is not quoted", key));
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos)
      return fail(fmt::format("the value of '{}' has no end", key), "is the file truncated?");
    std::string value;
    if (!resolve(text_.substr(at_ + 1, end - at_ - 1), value)) return false;
    element.attributes.emplace_back(key, std::move(value));
    advance(end + 1 - at_);
    return true;
  }

  bool resolve(std::string_view raw, std::string& value) {
    for (std::size_t i = 0; i < raw.size();) {
      if (raw[i] == '<') return fail("'<' inside the value of an attribute", "write &lt;");
      std::size_t used = 1;
      if (raw[i] != '&') {
        value += raw[i];
      } else if (!resolve_entity(raw.substr(i), value, used)) {
        return false;
      }
      i += used;
    }
    return true;
  }

  bool resolve_entity(std::string_view raw, std::string& value, std::size_t& used) {
    constexpr std::array<std::pair<std::string_view, char>, 5> kEntities = {
        {{"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}}};
    for (const auto& [text, character] : kEntities) {
      if (!raw.starts_with(text)) continue;
      value += character;
      used = text.size();
      return true;
    }
    return fail(fmt::format("unknown entity '{}'", raw.substr(0, 8)), "&lt; &gt; &amp; &quot; &apos;");
  }

  std::string scan_name() {
    const std::size_t begin = at_;
    if (at_ < text_.size() && is_name_start(text_[at_])) {
      while (at_ < text_.size() && is_name(text_[at_])) ++at_;
    }
    return std::string(text_.substr(begin, at_ - begin));
  }

  bool skip_space() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_space(text_[at_])) advance(1);
    return at_ > begin;
  }

  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    advance(1);
    return true;
  }

  void advance(std::size_t count) {
    const auto begin = text_.begin() + static_cast<std::ptrdiff_t>(at_);
    line_ += static_cast<int>(std::count(begin, begin + static_cast<std::ptrdiff_t>(count), '\n'));
    at_ += count;
  }

  std::string_view text_;
  std::string sanitized_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::vector<XmlElement> elements_;
  std::vector<int> open_;
  Diagnostics diagnostics_;
};

}  // namespace

const std::string* XmlElement::attribute(std::string_view key) const {
  const auto found = std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.first == key; });
  return found == attributes.end() ? nullptr : &found->second;
}

std::vector<const XmlElement*> XmlTree::children(const XmlElement& element, std::string_view name) const {
  std::vector<const XmlElement*> found;
  for (const int child : element.children) {
    const XmlElement& candidate = elements[static_cast<std::size_t>(child)];
    if (candidate.name == name) found.push_back(&candidate);
  }
  return found;
}

Result<XmlTree> scan_xml(std::string_view text) { return Scanner(text).run(); }

}  // namespace takt::kinematics
