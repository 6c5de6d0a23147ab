/// \file
/// Decoded messages of clients.
#pragma once

#include <stdexcept>
#include <string_view>

#include <nlohmann/json.hpp>

namespace palpate {

using Json = nlohmann::json;

/// Thrown for client input that the server rejects; what() tells the client why.
class Refusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Maximum nesting depth of arrays and objects in a message; the parser recurses once per level.
inline constexpr std::size_t kMostLevels = 32;

/// Decodes a text frame. \throws Refusal if it is not one JSON value of at most kMostLevels levels.
Json decode_json(std::string_view text);

/// Encodes as JSON text in one line. Invalid UTF-8, as in file names, is replaced.
std::string encode_json(const Json& json);

/// Decodes a binary frame: CBOR (RFC 8949) of definite lengths, without tags, as JavaScript encoders produce
/// it. \throws Refusal likewise.
Json decode_cbor(std::string_view bytes);

/// \name Fields of a message
/// \throws Refusal, naming the field, if its type is wrong.
/// @{
/// Returns a string; empty if absent.
std::string text_field(const Json& message, const char* name);
/// Returns a finite number; `missing` if absent.
double number_field(const Json& message, const char* name, double missing);
/// Returns the field as it is.
const Json& field(const Json& message, const char* name);
/// @}

}  // namespace palpate
