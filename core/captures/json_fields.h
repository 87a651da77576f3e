// Fields of JSON objects that others wrote, read in one place: none where the object has no such field, or one of
// another type. What that means, and the words for it, are the caller's.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace ldp {

// `object` may be any JSON; what is no object has no fields.
template <typename Json>
const Json* field(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

template <typename Json>
std::optional<double> number_field(const Json& object, const char* key) {
  const Json* value = field(object, key);
  return value && value->is_number() ? std::optional(value->template get<double>()) : std::nullopt;
}

template <typename Json>
std::optional<int64_t> integer_field(const Json& object, const char* key) {
  const Json* value = field(object, key);
  return value && value->is_number_integer() ? std::optional(value->template get<int64_t>()) : std::nullopt;
}

template <typename Json>
std::optional<bool> flag_field(const Json& object, const char* key) {
  const Json* value = field(object, key);
  return value && value->is_boolean() ? std::optional(value->template get<bool>()) : std::nullopt;
}

template <typename Json>
std::optional<std::string> text_field(const Json& object, const char* key) {
  const Json* value = field(object, key);
  return value && value->is_string() ? std::optional(value->template get<std::string>()) : std::nullopt;
}

}  // namespace ldp
