#include "tests/support/json_mutator.h"

#include <array>
#include <set>

#include <nlohmann/json.hpp>

namespace takt::test {
namespace {

using Json = nlohmann::ordered_json;

class JsonMutator {
 public:
  JsonMutator(Json& document, const std::vector<std::string>& words, Random& random)
      : document_(document), words_(words), random_(random) {}

  void change() {
    using Change = void (JsonMutator::*)(Json&);
    static constexpr std::array<Change, 7> kChanges = {&JsonMutator::lose_one,     &JsonMutator::double_one,
                                                       &JsonMutator::rename_one,   &JsonMutator::other_value,
                                                       &JsonMutator::other_value,  &JsonMutator::take_from_elsewhere,
                                                       &JsonMutator::wrap_in_array};
    (this->*kChanges[below(kChanges.size())])(any_place());
  }

 private:
  std::size_t below(std::size_t n) { return random_.bits() % n; }
  bool heads() { return random_.bits() % 2 == 0; }

  /// A walk from the root that stops somewhere.
  Json& any_place() {
    Json* place = &document_;
    while (place->is_structured() && !place->empty() && below(8) != 0) place = &child(*place);
    return *place;
  }
  Json& child(Json& parent) {
    auto at = parent.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(below(parent.size())));
    return *at;
  }
  std::string word() { return words_.empty() ? "x" : words_[below(words_.size())]; }

  void lose_one(Json& place) {
    if (!place.is_structured() || place.empty()) return other_value(place);
    auto at = place.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(below(place.size())));
    place.erase(at);
  }
  void double_one(Json& place) {
    if (place.is_array() && !place.empty()) {
      const Json copy = child(place);
      place.push_back(copy);
    } else if (place.is_object() && !place.empty()) {
      const Json copy = child(place);
      place[word()] = copy;
    }
  }
  void rename_one(Json& place) {
    if (!place.is_object() || place.empty()) return other_value(place);
    auto at = place.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(below(place.size())));
    const Json value = *at;
    std::string key = at.key();
    place.erase(at);
    if (heads() && !key.empty()) {
      key.erase(below(key.size()), 1);
    } else {
      key = word();
    }
    place[key] = value;
  }
  void other_value(Json& place) {
    static const std::array<Json, 18> kEdges = {
        0,   -0.0, 1,    -1,    0.5,     1e-300, 1e300,         -1e300,         360,
        1e9, -1e9, true, false, nullptr, "",     Json::array(), Json::object(), 9007199254740993};
    if (place.is_string() && heads()) {
      place = word();
    } else if (place.is_number() && heads()) {
      place = place.get<double>() * random_.uniform(-3.0, 3.0);
    } else {
      place = kEdges[below(kEdges.size())];
    }
  }
  void take_from_elsewhere(Json& place) {
    const Json copy = any_place();
    if (copy.dump().size() < 2000) place = copy;
  }
  void wrap_in_array(Json& place) {
    const Json copy = place;
    place = Json::array({copy});
  }

  Json& document_;
  const std::vector<std::string>& words_;
  Random& random_;
};

void collect(const Json& place, std::set<std::string>& words) {
  if (place.is_string()) words.insert(place.get<std::string>());
  if (place.is_object())
    for (const auto& [key, value] : place.items()) words.insert(key);
  if (place.is_structured())
    for (const Json& value : place) collect(value, words);
}

}  // namespace

std::vector<std::string> words_of(const Json& document) {
  std::set<std::string> words;
  collect(document, words);
  return {words.begin(), words.end()};
}

std::string mutated_json(const Json& document, const std::vector<std::string>& words, Random& random) {
  Json copy = document;
  JsonMutator mutator(copy, words, random);
  for (std::uint64_t left = 1 + random.bits() % 4; left > 0; --left) mutator.change();
  return copy.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace takt::test
