#include "core/base/json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/utf8.h"

namespace takt {
namespace {

using Json = nlohmann::ordered_json;

/// A file with more is not read to its end: nobody reads the rest of the list either.
constexpr std::size_t kMostDuplicates = 100;

bool is_word_sign(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string_view("+-._").find(c) != std::string_view::npos;
}

/// What ends with the last of `position` characters that were read: a word or number, a text in quotes, or one sign.
/// @param of_word  a word is known to be wrong only by the sign behind it
std::string found_at(std::string_view text, std::size_t position, bool of_word) {
  constexpr std::size_t kMost = 40;
  std::size_t begin = std::min(std::max<std::size_t>(position, 1), text.size()) - 1;
  if (of_word && begin > 0 && !is_word_sign(text[begin])) --begin;
  std::size_t end = begin + 1;
  if (text[begin] == '"' && begin > 0) {
    const std::size_t quote = text.rfind('"', begin - 1);
    if (quote != std::string_view::npos && end - quote <= kMost) begin = quote;
  }
  if (is_word_sign(text[begin])) {
    while (begin > 0 && end - begin < kMost && is_word_sign(text[begin - 1])) --begin;
    while (end < text.size() && end - begin < kMost && is_word_sign(text[end])) ++end;
  }
  return to_valid_utf8(text.substr(begin, end - begin));
}

/// An error of syntax as a person would put it. Of what the library says ("syntax error while parsing object key ...")
/// only what it was reading, and what the trouble is, are of use.
std::pair<std::string, std::string> syntax_error(std::string_view what, std::string_view text, std::size_t position) {
  const std::string_view in_its_words = what.substr(0, what.find("; last read"));
  const auto says = [&](std::string_view words) { return in_its_words.find(words) != std::string_view::npos; };
  const bool at_end = position > text.size() || text.empty() || says("unexpected end of input");
  const bool of_word = says("invalid literal") || says("invalid number");
  const std::string found = at_end ? "the text ends" : fmt::format("'{}'", found_at(text, position, of_word));
  if (says("UTF-8")) return {fmt::format("{} is not valid UTF-8", found), "a text in UTF-8"};
  if (says("invalid string")) return {fmt::format("{} in a text in quotes", found), "a text ends with \" in its line"};
  if (says("invalid number")) return {fmt::format("{} is not a number", found), "a number such as -0.5 or 1e-3"};
  if (says("invalid literal"))
    return {fmt::format("{} is not a value", found), "a number, a text in quotes, true, false, null, [...] or {...}"};
  if (says("while parsing object key")) return {fmt::format("{} instead of a key", found), "a key in quotes"};
  if (says("while parsing object separator")) return {fmt::format("{} behind a key", found), "a colon"};
  if (says("while parsing object")) return {fmt::format("{} inside of an object", found), "a comma or }"};
  if (says("while parsing array")) return {fmt::format("{} inside of an array", found), "a comma or ]"};
  if (says("; expected end of input")) return {fmt::format("{} behind the end of the document", found), "one value"};
  return {fmt::format("{} instead of a value", found), "a number, a text in quotes, true, false, null, [...] or {...}"};
}

/// Builds the document value by value, so that depth, duplicates and range are judged before anything is stored.
class BoundedBuilder : public nlohmann::json_sax<Json> {
 public:
  BoundedBuilder(std::string_view text, const InputLimits& limits) : text_(text), limits_(limits) {}

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t&) override { return false; }
  bool number_float(number_float_t value, const string_t& text) override {
    if (!std::isfinite(value))
      diagnostics_.error(Code::kOutOfRange, pointer(), fmt::format("number {} is not finite", text));
    return put(value);
  }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    levels_.back().key = std::move(name);
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    // A number that is too large reads "[json.exception...] number overflow parsing '1e999'".
    const std::string_view what = error.what();
    const std::size_t quote = what.find('\'');
    if (what.find("parse error") != std::string_view::npos) {
      const auto [message, hint] = syntax_error(what, text_, position);
      diagnostics_.error(Code::kSyntax, pointer(), message, hint);
    } else {
      diagnostics_.error(
          Code::kOutOfRange, pointer(), fmt::format("number {} is out of range", quoted_in(what, quote)),
          fmt::format("Keep it to at most {:.6g} in size; byte {}", std::numeric_limits<double>::max(), position));
    }
    locate_last(position);
    return false;
  }

  Json document;
  Diagnostics diagnostics_;

 private:
  struct Level {
    Json* value;
    std::string key;
  };

  /// The text between the quote at `quote` and the last one; what is longer than any number is cut.
  static std::string_view quoted_in(std::string_view text, std::size_t quote) {
    if (quote == std::string_view::npos) return {};
    const std::size_t end = text.rfind('\'');
    return text.substr(quote + 1, std::min<std::size_t>(end > quote ? end - quote - 1 : 0, 40));
  }

  /// The last diagnostic is where the reader stopped, after `position` bytes: not where the element around it begins.
  void locate_last(std::size_t position) {
    const std::string_view read = text_.substr(0, std::max<std::size_t>(position, 1) - 1);
    Diagnostic& last = diagnostics_.list().back();
    last.line = 1 + static_cast<int>(std::ranges::count(read, '\n'));
    last.column = static_cast<int>(read.size() - (read.rfind('\n') + 1)) + 1;
  }

  Json* place(Json value) {
    if (levels_.empty()) {
      document = std::move(value);
      return &document;
    }
    Level& level = levels_.back();
    if (level.value->is_array()) {
      level.value->push_back(std::move(value));
      return &level.value->back();
    }
    // Keys are compared when the object is complete; operator[] would search all of it for each.
    auto& members = level.value->get_ref<Json::object_t&>();
    members.emplace_back(level.key, std::move(value));
    return &members.back().second;
  }

  template <class T>
  bool put(T&& value) {
    place(Json(std::forward<T>(value)));
    return true;
  }

  bool open(Json empty) {
    if (levels_.size() >= limits_.depth) {
      diagnostics_.error(Code::kTooLarge, pointer(), fmt::format("nested deeper than {} levels", limits_.depth),
                         "Put the inner part into a file or a program of its own");
      return false;
    }
    Json* value = place(std::move(empty));
    levels_.push_back({value, {}});
    return true;
  }

  bool close() {
    const bool goes_on = !levels_.back().value->is_object() || check_keys(levels_.back());
    levels_.pop_back();
    return goes_on;
  }

  /// A diagnostic for every key that an object has more than once. @return false: too many for a person to read
  bool check_keys(Level& level) {
    std::vector<std::string_view> keys;
    for (const auto& [key, value] : level.value->get_ref<const Json::object_t&>()) keys.push_back(key);
    std::ranges::sort(keys);
    for (std::size_t i = 1; i < keys.size(); ++i) {
      if (keys[i] != keys[i - 1]) continue;
      level.key = keys[i];
      diagnostics_.error(Code::kDuplicate, pointer(), fmt::format("duplicate key '{}' in this object", level.key),
                         "Remove one of the two");
      if (diagnostics_.list().size() >= kMostDuplicates) return false;
    }
    return true;
  }

  std::string pointer() const {
    std::string text;
    for (const Level& level : levels_) {
      // The innermost array waits for its next element, the others hold the one that is being read already.
      const std::size_t placed = &level == &levels_.back() ? 0 : 1;
      text += level.value->is_array() ? pointer_segment(level.value->size() - placed) : pointer_segment(level.key);
    }
    return text;
  }

  std::string_view text_;
  const InputLimits& limits_;
  std::vector<Level> levels_;
};

}  // namespace

Result<Json> parse_json(std::string_view text, const InputLimits& limits) {
  if (text.size() > limits.bytes) {
    return failure(Code::kTooLarge, {}, fmt::format("{} bytes of JSON", text.size()),
                   fmt::format("Keep it to at most {}", limits.bytes));
  }
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
    return failure(Code::kMissing, {}, "the file is empty", "Write JSON into it");
  BoundedBuilder builder(text, limits);
  const bool parsed = Json::sax_parse(text, &builder);
  if (!parsed && !builder.diagnostics_.has_errors()) builder.diagnostics_.error(Code::kSyntax, {}, "not JSON");
  if (builder.diagnostics_.has_errors()) return std::unexpected(std::move(builder.diagnostics_));
  return std::move(builder.document);
}

Result<std::string> read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  std::error_code error;
  const auto fail = [&](std::string message, Code code = Code::kFileNotReadable) {
    Diagnostics diagnostics;
    diagnostics.error(code, {}, std::move(message));
    diagnostics.set_file(path.string());
    return std::unexpected(std::move(diagnostics));
  };
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::none)
    return fail(fmt::format("cannot be read: {}", error.message()));
  if (!std::filesystem::exists(status)) return fail("there is no such file", Code::kNotFound);
  if (!std::filesystem::is_regular_file(status)) return fail("this is not a regular file");
  const auto size = std::filesystem::file_size(path, error);
  if (error) return fail(fmt::format("cannot be read: {}", error.message()));
  if (size > max_bytes) return fail(fmt::format("{} bytes, at most {} are read", size, max_bytes), Code::kTooLarge);
  std::ifstream stream(path, std::ios::binary);
  std::string bytes(size, '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) return fail("cannot be read");
  return bytes;
}

Result<Json> read_json(const std::filesystem::path& path, const InputLimits& limits) {
  auto text = read_file(path, limits.bytes);
  if (!text) return std::unexpected(std::move(text.error()));
  auto document = parse_json(*text, limits);
  if (!document) document.error().set_file(path.string());
  return document;
}

Result<std::filesystem::path> resolve_below(const std::filesystem::path& root, std::string_view relative,
                                            const std::string& pointer) {
  const std::filesystem::path path(relative);
  const std::string hint = "Give a relative path to something inside the folder of the file";
  if (path.empty() || path.is_absolute())
    return failure(Code::kFileNotReadable, pointer, fmt::format("path '{}' is not allowed", relative), hint);
  std::error_code error;
  const auto base = std::filesystem::weakly_canonical(root, error);
  const auto full = std::filesystem::weakly_canonical(base / path, error);
  const auto inside = full.lexically_relative(base);
  if (error || inside.empty() || *inside.begin() == "..") {
    return failure(Code::kFileNotReadable, pointer, fmt::format("path '{}' leaves its folder", relative), hint);
  }
  return full;
}

}  // namespace takt
