/// \file
/// Messages of clients, as values.
#pragma once

#include <stdexcept>
#include <string_view>

#include <nlohmann/json.hpp>

namespace palpate {

using Json = nlohmann::json;

/// What a client sent and the server does not take; what() tells the client why.
class Refusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Levels of arrays and objects in a message. The parser calls itself for each.
inline constexpr std::size_t kMostLevels = 32;

/// A text frame. \throws Refusal if it is not one JSON value of at most kMostLevels.
Json decode_json(std::string_view text);

/// As text in one line. Strings that are not UTF-8, as names of files may be, are replaced where they are
/// not.
std::string encode_json(const Json& json);

/// A binary frame: CBOR (RFC 8949) of definite lengths, without tags, as encoders for the web make it.
/// \throws Refusal likewise.
Json decode_cbor(std::string_view bytes);

/// \name Fields of a message
/// \throws Refusal, naming the field, if it is not what it is asked for.
/// @{
/// Empty if it is not there.
std::string text_field(const Json& message, const char* name);
/// A finite number; `missing` if it is not there.
double number_field(const Json& message, const char* name, double missing);
/// As it is there.
const Json& field(const Json& message, const char* name);
/// @}

}  // namespace palpate
