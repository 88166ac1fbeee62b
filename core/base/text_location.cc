#include "core/base/text_location.h"

#include <algorithm>
#include <vector>

#include "core/base/json.h"

namespace takt {
namespace {

/// Walks over the tokens of a JSON text and keeps the pointer of the element that it is at.
class JsonWalk {
 public:
  JsonWalk(std::string_view text, const std::set<std::string, std::less<>>& wanted) : text_(text), wanted_(wanted) {
    found_.emplace("", TextLocation{});
  }

  std::map<std::string, TextLocation, std::less<>> run() {
    while (skip_blanks()) step();
    return std::move(found_);
  }

 private:
  struct Level {
    bool object;
    bool expects_key;    ///< the next text is a key
    std::size_t length;  ///< of the pointer of the container
    std::size_t index = 0;
  };

  bool skip_blanks() {
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n') {
        ++line_;
        line_begin_ = at_ + 1;
      } else if (c != ' ' && c != '\t' && c != '\r') {
        return true;
      }
    }
    return false;
  }

  void step() {
    switch (text_[at_]) {
      case '{':
      case '[':
        return open(text_[at_] == '{');
      case '}':
      case ']':
        return close();
      case ',':
        return next();
      case ':':
        ++at_;
        return;
      case '"':
        return text();
      default:
        return scalar();
    }
  }

  void open(bool object) {
    element();
    levels_.push_back({object, object, pointer_.size()});
    ++at_;
  }

  void close() {
    ++at_;
    if (levels_.empty()) return;
    pointer_.resize(levels_.back().length);
    levels_.pop_back();
  }

  void next() {
    ++at_;
    if (levels_.empty()) return;
    Level& level = levels_.back();
    level.expects_key = level.object;
    ++level.index;
  }

  void text() {
    const std::size_t begin = at_;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\') ++at_;
    }
    at_ = std::min(at_ + 1, text_.size());
    if (levels_.empty() || !levels_.back().expects_key) return element(begin);
    Level& level = levels_.back();
    level.expects_key = false;
    pointer_.resize(level.length);
    // A key with escapes stays as it is written: pointers into it are found at the element around it.
    pointer_ += pointer_segment(text_.substr(begin + 1, at_ - begin - 2));
    remember(begin);
  }

  void scalar() {
    element();
    while (at_ < text_.size() && !std::string_view(",:]}\n\t\r \"[{").contains(text_[at_])) ++at_;
  }

  void element() { element(at_); }
  /// The element of an array begins; that of an object is known by its key.
  void element(std::size_t begin) {
    if (levels_.empty() || levels_.back().object) return;
    pointer_.resize(levels_.back().length);
    pointer_ += pointer_segment(levels_.back().index);
    remember(begin);
  }

  void remember(std::size_t begin) {
    if (wanted_.contains(pointer_))
      found_.emplace(pointer_, TextLocation{line_, static_cast<int>(begin - line_begin_) + 1});
  }

  std::string_view text_;
  const std::set<std::string, std::less<>>& wanted_;
  std::map<std::string, TextLocation, std::less<>> found_;
  std::vector<Level> levels_;
  std::string pointer_;
  std::size_t at_ = 0;
  std::size_t line_begin_ = 0;
  int line_ = 1;
};

/// The pointer of the element around this one; "" stays.
std::string_view parent_of(std::string_view pointer) { return pointer.substr(0, pointer.rfind('/')); }

bool is_json_pointer(const Diagnostic& diagnostic) {
  return !diagnostic.file.empty() && diagnostic.file.ends_with(".json") && diagnostic.line == 0 &&
         (diagnostic.pointer.empty() || diagnostic.pointer.starts_with('/'));
}

}  // namespace

std::map<std::string, TextLocation, std::less<>> locate_pointers(std::string_view json,
                                                                 const std::set<std::string, std::less<>>& pointers) {
  std::set<std::string, std::less<>> wanted;
  for (std::string_view pointer : pointers)
    for (; !pointer.empty(); pointer = parent_of(pointer)) wanted.emplace(pointer);
  const auto found = JsonWalk(json, wanted).run();
  std::map<std::string, TextLocation, std::less<>> located;
  for (const std::string& pointer : pointers) {
    std::string_view nearest = pointer;
    while (!found.contains(nearest)) nearest = parent_of(nearest);
    located.emplace(pointer, found.find(nearest)->second);
  }
  return located;
}

void locate(Diagnostics& diagnostics) {
  std::map<std::string, std::set<std::string, std::less<>>> pointers_of;
  for (const Diagnostic& one : diagnostics.list())
    if (is_json_pointer(one) && !one.pointer.empty()) pointers_of[one.file].insert(one.pointer);
  for (const auto& [file, pointers] : pointers_of) {
    const auto text = read_file(file, InputLimits{}.bytes);
    if (!text) continue;
    const auto located = locate_pointers(*text, pointers);
    for (Diagnostic& one : diagnostics.list()) {
      if (one.file != file || !is_json_pointer(one) || one.pointer.empty()) continue;
      one.line = located.at(one.pointer).line;
      one.column = located.at(one.pointer).column;
    }
  }
}

std::string to_located_text(Diagnostics diagnostics) {
  locate(diagnostics);
  return diagnostics.to_string();
}

}  // namespace takt
