#include "languages/script/engine.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>

#include <duktape.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "languages/xml/document.h"

namespace takt::languages {
namespace {

/// A script that has no steps left gets so many more to find its end after the error.
constexpr std::int64_t kGrace = 64;
/// Instructions between two questions of the engine whether it may go on.
constexpr std::int64_t kInstructions = 262'144;
/// One use of a regular expression may try so much, and counts as a part of that.
constexpr int kExpressionSteps = 100'000, kExpressionCost = 10'000;

/// XML as scripts see it: the part of the Document Object Model that SCXML needs.
constexpr const char* kPrelude = R"JS((function (global) {
  'use strict';
  function Node(tree, xml) {
    var children = tree.c.map(function (one) { return typeof one === 'string' ? one : new Node(one, ''); });
    Object.defineProperty(this, '$xml', {value: xml});
    Object.defineProperty(this, '$children', {value: children});
    Object.defineProperty(this, '$attributes', {value: tree.a});
    this.tagName = this.nodeName = tree.n;
  }
  Node.prototype.getAttribute = function (name) {
    return Object.prototype.hasOwnProperty.call(this.$attributes, name) ? this.$attributes[name] : null;
  };
  Node.prototype.getElementsByTagName = function (name) {
    var found = [];
    (function visit(node) {
      node.$children.forEach(function (one) {
        if (typeof one === 'string') return;
        if (name === '*' || one.tagName === name) found.push(one);
        visit(one);
      });
    })(this);
    return found;
  };
  Object.defineProperty(Node.prototype, 'childNodes', {get: function () { return this.$children.slice(); }});
  Object.defineProperty(Node.prototype, 'textContent', {get: function () {
    return this.$children.map(function (one) { return typeof one === 'string' ? one : one.textContent; }).join('');
  }});
  Object.freeze(Node.prototype);
  ['Date', 'performance', 'Duktape', 'Proxy', 'Reflect', 'CBOR', 'TextEncoder', 'TextDecoder', 'Buffer', 'ArrayBuffer',
   'DataView', 'Int8Array', 'Uint8Array', 'Uint8ClampedArray', 'Int16Array', 'Uint16Array', 'Int32Array', 'Uint32Array',
   'Float32Array', 'Float64Array'].forEach(function (name) { delete global[name]; });
  return [function (tree, xml) { return new Node(tree, xml); }, function (event, data) {
    ['sendid', 'origin', 'origintype', 'invokeid'].forEach(function (key) {
      if (!(key in event)) event[key] = undefined;
    });
    event.data = data;
    return Object.freeze(event);
  }];
})(this))JS";

nlohmann::ordered_json tree_of(const XmlElement& element) {
  nlohmann::ordered_json tree{
      {"n", element.name}, {"a", nlohmann::ordered_json::object()}, {"c", nlohmann::ordered_json::array()}};
  for (const XmlAttribute& one : element.attributes) tree["a"][one.name] = one.value;
  for (const XmlElement::Child& child : element.children)
    tree["c"].push_back(child.element ? tree_of(*child.element) : nlohmann::ordered_json(child.text));
  return tree;
}

/// What the engine asks about while it runs a script: memory, steps, random numbers.
struct ScriptHeap {
  ScriptLimits limits;
  Random random;
  std::int64_t steps = 0;
  std::size_t bytes = 0;
  bool out_of_memory = false;
  std::function<bool(const std::string&)> in = {};

  /// True if the script has to end.
  bool charge(std::int64_t count) {
    const std::int64_t before = steps;
    steps += count;
    return before > limits.steps ? (before - limits.steps) % kGrace == 0 : steps > limits.steps;
  }
  [[nodiscard]] bool exhausted() const { return steps > limits.steps || out_of_memory; }

  void* allocate(std::size_t size) {
    if (bytes + size > limits.bytes) return out_of_memory = true, nullptr;
    auto* block = static_cast<std::size_t*>(std::malloc(size + kHeader));
    if (block == nullptr) return nullptr;
    *block = size;
    bytes += size;
    return reinterpret_cast<char*>(block) + kHeader;
  }
  void* reallocate(void* pointer, std::size_t size) {
    if (pointer == nullptr) return allocate(size);
    if (size == 0) return release(pointer), nullptr;
    auto* block = reinterpret_cast<std::size_t*>(static_cast<char*>(pointer) - kHeader);
    const std::size_t before = *block;
    if (size > before && bytes + (size - before) > limits.bytes) return out_of_memory = true, nullptr;
    auto* moved = static_cast<std::size_t*>(std::realloc(block, size + kHeader));
    if (moved == nullptr) return nullptr;
    *moved = size;
    bytes += size - before;
    return reinterpret_cast<char*>(moved) + kHeader;
  }
  void release(void* pointer) {
    if (pointer == nullptr) return;
    auto* block = reinterpret_cast<std::size_t*>(static_cast<char*>(pointer) - kHeader);
    bytes -= *block;
    std::free(block);
  }
  bool is_in(const char* state) { return in && in(state); }

  static constexpr std::size_t kHeader = alignof(std::max_align_t);
};

void* allocate_for(void* heap, duk_size_t size) { return static_cast<ScriptHeap*>(heap)->allocate(size); }
void* reallocate_for(void* heap, void* pointer, duk_size_t size) {
  return static_cast<ScriptHeap*>(heap)->reallocate(pointer, size);
}
void release_for(void* heap, void* pointer) { static_cast<ScriptHeap*>(heap)->release(pointer); }
/// All calls are protected, so this is an error of this program.
void die(void*, const char*) { std::terminate(); }

duk_ret_t answer_in(duk_context* context) {
  duk_memory_functions functions;
  duk_get_memory_functions(context, &functions);
  duk_push_boolean(context, static_cast<ScriptHeap*>(functions.udata)->is_in(duk_require_string(context, 0)));
  return 1;
}

/// Replaces the value by its text; the kind tells of what.
duk_ret_t value_to_text(duk_context* context, void* kind_of) {
  auto& kind = *static_cast<Data::Kind*>(kind_of);
  if (duk_is_object(context, -1) && !duk_is_function(context, -1)) {
    duk_get_prop_string(context, -1, "$xml");
    if (duk_is_string(context, -1) && duk_get_length(context, -1) > 0) {
      kind = Data::Kind::kXml;
      return 1;
    }
    duk_pop(context);
  }
  (void)duk_json_encode(context, -1);
  kind = duk_is_string(context, -1) ? Data::Kind::kJson : Data::Kind::kUndefined;
  return 1;
}

/// What a call into the engine needs and gives. Errors of the engine jump over C++ frames, so nothing in them owns
/// anything.
struct Call {
  const char* text = "";
  const char* other = "";
  const char* third = "";
  Data::Kind kind = Data::Kind::kUndefined;
  std::size_t number = 0;
  bool flag = false;
  void (*act)(duk_context* context, Call& call) = nullptr;
};

constexpr const char* kFunctions =
    "\xFF"
    "functions";
constexpr const char* kMakeXml =
    "\xFF"
    "xml";
constexpr const char* kMakeEvent =
    "\xFF"
    "event";
constexpr const char* kLoops =
    "\xFF"
    "loops";

/// Pushes a function that is compiled once. @param head, tail  around the text
void push_function(duk_context* context, const char* head, const char* text, const char* tail) {
  duk_push_global_stash(context);
  duk_get_prop_string(context, -1, kFunctions);
  duk_push_string(context, head);
  duk_push_string(context, text);
  duk_push_string(context, tail);
  duk_concat(context, 3);
  duk_dup(context, -1);
  if (!duk_get_prop(context, -3)) {
    duk_pop(context);
    duk_dup(context, -1);
    duk_push_string(context, "chart");
    duk_compile(context, DUK_COMPILE_EVAL);
    duk_call(context, 0);
    duk_dup(context, -2);
    duk_dup(context, -2);
    duk_put_prop(context, -5);
  }
  duk_replace(context, -4);
  duk_pop_2(context);
}

void push_value(duk_context* context, const char* expression) {
  push_function(context, "(function(){return (", expression, "\n)})");
  duk_push_global_object(context);
  duk_call_method(context, 0);
}

/// Pushes a value from outside; of XML `other` is the tree as JSON.
void push_data(duk_context* context, const Call& call) {
  if (call.kind == Data::Kind::kUndefined) return duk_push_undefined(context);
  if (call.kind == Data::Kind::kXml) {
    duk_push_global_stash(context);
    duk_get_prop_string(context, -1, kMakeXml);
    duk_push_string(context, call.third);
    duk_json_decode(context, -1);
    duk_push_string(context, call.other);
    duk_call(context, 2);
    duk_remove(context, -2);
    return;
  }
  duk_push_string(context, call.other);
  duk_json_decode(context, -1);
}

/// Gives the variable that is named the value on the stack.
void put_global(duk_context* context, const char* name) {
  push_function(context, "(function($value$){", name, "=$value$;})");
  duk_dup(context, -2);
  duk_call(context, 1);
  duk_pop(context);
}

duk_ret_t enter(duk_context* context, void* udata) {
  Call& call = *static_cast<Call*>(udata);
  call.act(context, call);
  return 1;
}

}  // namespace

struct ScriptEngine::Impl {
  Impl(std::uint64_t seed, const ScriptLimits& limits) : heap{.limits = limits, .random = Random(seed)} {}

  ScriptHeap heap;
  duk_context* context = nullptr;

  /// Runs what a call asks for. @return what it left on the stack
  Value<Data> run(Call& call) {
    heap.steps = 0;
    heap.out_of_memory = false;
    Value<Data> result = duk_safe_call(context, enter, &call, 0, 1) == 0 ? take() : std::unexpected(why());
    duk_set_top(context, 0);
    return result;
  }
  Value<void> run_only(Call& call) {
    auto result = run(call);
    if (!result) return std::unexpected(std::move(result.error()));
    return {};
  }

  Value<Data> take() {
    Data data;
    if (duk_safe_call(context, value_to_text, &data.kind, 1, 1) != 0) return std::unexpected(why());
    if (data.kind == Data::Kind::kUndefined) return data;
    duk_size_t size = 0;
    const char* text = duk_get_lstring(context, -1, &size);
    data.text.assign(text, size);
    return data;
  }

  /// The error on the stack, in words.
  [[nodiscard]] std::string why() const {
    if (heap.steps > heap.limits.steps) return fmt::format("more than {} steps without an end", heap.limits.steps);
    if (heap.out_of_memory) return fmt::format("more than {} bytes", heap.limits.bytes);
    const char* text = duk_safe_to_string(context, -1);
    return text != nullptr ? text : "an error without a text";
  }

  /// Puts a value into a call; of XML also its tree. @param tree  keeps the text
  static void give(Call& call, const Data& value, std::string& tree) {
    call.kind = value.kind;
    call.other = value.text.c_str();
    if (value.kind != Data::Kind::kXml) return;
    if (const auto parsed = parse_xml(value.text)) {
      tree = tree_of(**parsed).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
      call.third = tree.c_str();
    } else {
      call.kind = Data::Kind::kUndefined;
    }
  }
};

ScriptEngine::ScriptEngine(std::uint64_t seed, const ScriptLimits& limits)
    : impl_(std::make_unique<Impl>(seed, limits)) {
  impl_->context = duk_create_heap(allocate_for, reallocate_for, release_for, &impl_->heap, die);
  if (impl_->context == nullptr) std::terminate();  // not even the empty engine fits
  Call call{.act = [](duk_context* context, Call&) {
    duk_push_global_stash(context);
    for (const char* name : {kFunctions, kLoops}) {
      duk_push_bare_object(context);
      duk_put_prop_string(context, -2, name);
    }
    duk_eval_string(context, kPrelude);
    duk_get_prop_index(context, -1, 0);
    duk_put_prop_string(context, -3, kMakeXml);
    duk_get_prop_index(context, -1, 1);
    duk_put_prop_string(context, -3, kMakeEvent);
    duk_push_c_function(context, answer_in, 1);
    duk_put_global_string(context, "In");
    duk_push_undefined(context);
  }};
  (void)impl_->run(call);
}

ScriptEngine::~ScriptEngine() { duk_destroy_heap(impl_->context); }

void ScriptEngine::set_in(std::function<bool(const std::string&)> in) { impl_->heap.in = std::move(in); }

namespace {

/// Documents end expressions with a semicolon now and then.
std::string without_semicolon(const std::string& expression) {
  const auto last = expression.find_last_not_of(" \t\r\n;");
  return last == std::string::npos ? expression : expression.substr(0, last + 1);
}

}  // namespace

ScriptEngine::Value<Data> ScriptEngine::evaluate(const std::string& given) {
  const std::string expression = without_semicolon(given);
  Call call{.text = expression.c_str(), .act = [](duk_context* context, Call& own) { push_value(context, own.text); }};
  return impl_->run(call);
}

ScriptEngine::Value<bool> ScriptEngine::condition(const std::string& given) {
  const std::string expression = without_semicolon(given);
  Call call{.text = expression.c_str(), .act = [](duk_context* context, Call& own) {
              push_value(context, own.text);
              own.flag = duk_to_boolean(context, -1) != 0;
              duk_push_undefined(context);
            }};
  if (const auto result = impl_->run(call); !result) return std::unexpected(result.error());
  return call.flag;
}

ScriptEngine::Value<void> ScriptEngine::execute(const std::string& statements) {
  Call call{.text = statements.c_str(), .act = [](duk_context* context, Call& own) {
              duk_push_string(context, own.text);
              duk_push_string(context, "chart");
              duk_compile(context, 0);
              duk_call(context, 0);
              duk_push_undefined(context);
            }};
  return impl_->run_only(call);
}

ScriptEngine::Value<void> ScriptEngine::declare(const std::string& name) {
  Call call{.text = name.c_str(), .act = [](duk_context* context, Call& own) {
              duk_push_global_object(context);
              if (!duk_has_prop_string(context, -1, own.text)) {
                duk_push_undefined(context);
                duk_put_prop_string(context, -2, own.text);
              }
              duk_push_undefined(context);
            }};
  return impl_->run_only(call);
}

namespace {

/// A global that scripts can read.
constexpr duk_uint_t kConstant = DUK_DEFPROP_HAVE_VALUE | DUK_DEFPROP_CLEAR_WRITABLE | DUK_DEFPROP_SET_ENUMERABLE |
                                 DUK_DEFPROP_CLEAR_CONFIGURABLE | DUK_DEFPROP_FORCE;

constexpr const char* kAssign = "(function($value$){\"use strict\";";

/// Gives the location of the call the value on the stack.
void assign_top(duk_context* context, const char* location) {
  push_function(context, kAssign, location, "\n=$value$;})");
  duk_dup(context, -2);
  duk_call(context, 1);
}

}  // namespace

ScriptEngine::Value<void> ScriptEngine::assign(const std::string& location, const std::string& given) {
  const std::string expression = without_semicolon(given);
  Call call{.text = location.c_str(), .other = expression.c_str(), .act = [](duk_context* context, Call& own) {
              push_value(context, own.other);
              assign_top(context, own.text);
            }};
  return impl_->run_only(call);
}

ScriptEngine::Value<void> ScriptEngine::assign(const std::string& location, const Data& value) {
  std::string tree;
  Call call{.text = location.c_str(), .act = [](duk_context* context, Call& own) {
              push_data(context, own);
              assign_top(context, own.text);
            }};
  Impl::give(call, value, tree);
  return impl_->run_only(call);
}

ScriptEngine::Value<void> ScriptEngine::set_event(const std::string& fields, const Data& data) {
  std::string tree;
  Call call{.text = fields.c_str(), .act = [](duk_context* context, Call& own) {
              duk_push_global_object(context);
              duk_push_string(context, "_event");
              duk_push_global_stash(context);
              duk_get_prop_string(context, -1, kMakeEvent);
              duk_remove(context, -2);
              duk_push_string(context, own.text);
              duk_json_decode(context, -1);
              push_data(context, own);
              duk_call(context, 2);
              duk_def_prop(context, -3, kConstant);
              duk_push_undefined(context);
            }};
  Impl::give(call, data, tree);
  return impl_->run_only(call);
}

ScriptEngine::Value<void> ScriptEngine::set_constant(const std::string& name, const Data& value) {
  std::string tree;
  Call call{.text = name.c_str(), .act = [](duk_context* context, Call& own) {
              duk_push_global_object(context);
              duk_push_string(context, own.text);
              push_data(context, own);
              if (duk_is_object(context, -1)) duk_freeze(context, -1);
              duk_def_prop(context, -3, kConstant);
              duk_push_undefined(context);
            }};
  Impl::give(call, value, tree);
  return impl_->run_only(call);
}

ScriptEngine::Value<std::size_t> ScriptEngine::begin_loop(const std::string& array) {
  Call call{.text = array.c_str(), .act = [](duk_context* context, Call& own) {
              push_value(context, own.text);
              if (!duk_is_array(context, -1)) (void)duk_type_error(context, "no array");
              own.number = duk_get_length(context, -1);
              duk_push_string(context, "slice");
              duk_call_prop(context, -2, 0);
              duk_push_global_stash(context);
              duk_get_prop_string(context, -1, kLoops);
              duk_get_prop_string(context, -1, "depth");
              const int depth = duk_get_int_default(context, -1, 0) + 1;
              duk_pop(context);
              duk_push_int(context, depth);
              duk_put_prop_string(context, -2, "depth");
              duk_dup(context, -3);
              duk_put_prop_index(context, -2, static_cast<duk_uarridx_t>(depth));
              duk_push_undefined(context);
            }};
  if (const auto result = impl_->run(call); !result) return std::unexpected(result.error());
  return call.number;
}

ScriptEngine::Value<void> ScriptEngine::enter_round(std::size_t round, const std::string& item,
                                                    const std::string& index) {
  Call call{.text = item.c_str(), .other = index.c_str(), .number = round, .act = [](duk_context* context, Call& own) {
              duk_push_global_stash(context);
              duk_get_prop_string(context, -1, kLoops);
              duk_get_prop_string(context, -1, "depth");
              duk_get_prop_index(context, -2, static_cast<duk_uarridx_t>(duk_get_int_default(context, -1, 0)));
              duk_get_prop_index(context, -1, static_cast<duk_uarridx_t>(own.number));
              put_global(context, own.text);
              if (*own.other != 0) {
                duk_push_number(context, static_cast<double>(own.number));
                put_global(context, own.other);
              }
              duk_push_undefined(context);
            }};
  return impl_->run_only(call);
}

void ScriptEngine::end_loop() {
  Call call{.act = [](duk_context* context, Call&) {
    duk_push_global_stash(context);
    duk_get_prop_string(context, -1, kLoops);
    duk_get_prop_string(context, -1, "depth");
    const int depth = duk_get_int_default(context, -1, 1);
    duk_pop(context);
    duk_del_prop_index(context, -1, static_cast<duk_uarridx_t>(depth));
    duk_push_int(context, depth - 1);
    duk_put_prop_string(context, -2, "depth");
    duk_push_undefined(context);
  }};
  (void)impl_->run(call);
}

bool ScriptEngine::exhausted() const { return impl_->heap.exhausted(); }

std::optional<std::string> ScriptEngine::syntax_error(const std::string& given, bool statements) {
  const std::string text = statements ? given : without_semicolon(given);
  Call call{.text = text.c_str(), .flag = statements, .act = [](duk_context* context, Call& own) {
              if (!own.flag) {
                push_function(context, "(function(){return (", own.text, "\n)})");
              } else {
                duk_push_string(context, own.text);
                duk_push_string(context, "chart");
                duk_compile(context, 0);
              }
              duk_push_undefined(context);
            }};
  const auto result = impl_->run(call);
  return result ? std::nullopt : std::optional(result.error());
}

bool is_script_name(std::string_view name) {
  static constexpr std::array kWords = {
      "break",   "case",       "catch",     "class",  "const",      "continue",  "debugger", "default", "delete",
      "do",      "else",       "enum",      "export", "extends",    "false",     "finally",  "for",     "function",
      "if",      "implements", "import",    "in",     "instanceof", "interface", "let",      "new",     "null",
      "package", "private",    "protected", "public", "return",     "static",    "super",    "switch",  "this",
      "throw",   "true",       "try",       "typeof", "var",        "void",      "while",    "with",    "yield"};
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '$' ||
           static_cast<unsigned char>(c) > 127;
  };
  if (name.empty() || !is_letter(name.front())) return false;
  const bool in_form = std::ranges::all_of(name, [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
  return in_form && std::ranges::find(kWords, name) == kWords.end();
}

}  // namespace takt::languages

extern "C" {
int takt_script_interrupted(void* heap) {
  auto* self = static_cast<takt::languages::ScriptHeap*>(heap);
  self->charge(takt::languages::kInstructions);
  return self->steps > self->limits.steps ? 1 : 0;
}
int takt_script_accessed(void* heap) { return static_cast<takt::languages::ScriptHeap*>(heap)->charge(1) ? 1 : 0; }
int takt_script_expression_steps(void* heap) {
  auto* self = static_cast<takt::languages::ScriptHeap*>(heap);
  (void)self->charge(takt::languages::kExpressionCost);
  return self->exhausted() ? 1 : takt::languages::kExpressionSteps;
}
double takt_script_random(void* heap) { return static_cast<takt::languages::ScriptHeap*>(heap)->random.unit(); }
}
